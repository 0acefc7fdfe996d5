#include "src/granular/gas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/effects/effects.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_state.hpp"
#include "src/model/surface_law.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/grain_threads.hpp"

namespace lichtenberg::granular {
namespace {

/// Returns the largest displacement (d0) of a grain within which it cannot come near two images of another grain.
double longest_travel(const Bodies& bodies) {
  double shortest = INFINITY;
  for (int k = 0; k < bodies.dimension; ++k)
    if (bodies.box.periodic(k)) shortest = std::min(shortest, bodies.box.lengths[k]);
  return 0.25 * shortest - *std::ranges::max_element(bodies.radius);
}

/// Returns the contacts of grains that overlap at the start, as in a scene made from a frame of another run. They do
/// not count as collisions, because their onset is past and its speed is unknown.
std::vector<GrainContact> contacts_at_start(const Bodies& bodies, parallel::Team& team) {
  std::vector<GrainContact> contacts;
  PairList list(0, 0);
  const std::span<const Pair> near = list.pairs(bodies, 0, team);
  visit_spheres(bodies, [&](const auto& grains) {
    for (const Pair pair : near)
      if (const auto state = pair_state(bodies, grains, pair); norm(state.separation) < reach(bodies, pair))
        contacts.push_back({.pair = pair, .impact_speed = std::max(0.0, closing(state)), .alone = false});
  });
  return contacts;
}

/// Returns the surface law that the effects and materials of the scene define.
SurfaceLaw surface_law(const Scene& scene, const Model& model) {
  SurfaceLaw law;
  for (const auto& effect : model.effects) effect->set_surface(law);
  for (const Conductor& grain : scene.conductors) law.materials.push_back(grain.material);
  return law;
}

/// Returns the contact with walls in a stage of equilibration, which changes it like that of two grains with the law
/// `given`.
WallContact in_stage(const WallContact& walls, const GrainContactLaw& given, const Stage& stage) {
  return std::visit(
      [&](auto law) {
        auto& [stiffness, damping] = law;
        stiffness = walls.stiffness.value_or(stiffness), damping = walls.damping.value_or(damping);
        law = law.stiffer(stage.stiffness);
        return WallContact{stiffness, stage.elastic ? 0 : damping, walls.friction};
      },
      given);
}

}  // namespace

Gas::Gas(const Scene& scene)
    : scene_(scene),
      team_(std::make_unique<parallel::Team>(threads_for_grains(scene))),
      model_(effects::make_model(scene)),
      law_(contact_law(scene, model_)),
      list_(0, 0.5),
      grain_properties_{std::ranges::min(model_.bodies.mass), std::ranges::min(model_.bodies.radius),
                        typical_impact(scene.conductors.size())} {
  std::optional<double> range;
  for (const auto& effect : model_.effects)
    if (const std::optional<double> needed = effect->needs().neighbour_range)
      range = std::max(*needed, range.value_or(*needed));
  if (range) smooth_list_.emplace(*range, 1);
  model_.team = team_.get();
  contacts_ = contacts_at_start(model_.bodies, *team_);
  set_rotation(scene_, surface_law(scene_, model_), model_.bodies);
  set_law();
  if (rough_ && !scene_.mechanics.integrator->has_surface_forces)
    throw InputError(fmt::format("{}: mechanics.integrator = \"{}\" does not compute the contacts of {}: {} is allowed",
                                 scene_.path, name_of(scene_.mechanics.integrator), surface_key(scene_),
                                 names_of(&IntegratorKind::has_surface_forces)));
}

Instant Gas::instant(Want want) {
  Instant now = instant();
  find_forces(now, want);
  return now;
}

GasEnergy Gas::energy(std::optional<double> potential) {
  GasEnergy budget = budget_;
  budget.kinetic = kinetic_energy();
  if (!model_.bodies.inertia.empty()) budget.rotational = rotational_energy(model_.bodies);
  budget.contact = contact_energy();
  budget.potential = potential_energy(potential);
  return budget;
}

double Gas::contact_energy() const {
  return rough_ ? rough_->stored_energy(model_.bodies, contacts_) : stored_energy(law_, model_.bodies, contacts_);
}

double Gas::mechanical_energy() const { return kinetic_energy() + contact_energy(); }

State Gas::state() {
  const Stopwatch stopwatch(seconds_.lists);
  std::span<const Pair> pairs;
  if (smooth_list_) pairs = smooth_list_->pairs(model_.bodies, 0, *team_);
  return {time_, model_.bodies, pairs, *team_};
}

double Gas::potential_energy(std::optional<double> known) {
  if (known) return *known;
  const State now = state();
  const Stopwatch stopwatch(seconds_.forces);
  double energy = 0;
  for (const auto& effect : model_.effects) energy += effect->stored_energy(now);
  return energy;
}

void Gas::find_forces(Instant& now, Want want) {
  if (!now.force.empty() || !has_smooth_forces()) return;
  now.force.assign(model_.bodies.momentum.size(), 0);
  {
    const State state = this->state();
    const Stopwatch stopwatch(seconds_.forces);
    double energy = 0;
    for (const auto& effect : model_.effects) {
      // The energy comes first: effects that compute both together keep the forces.
      if (want == Want::energy) energy += effect->stored_energy(state);
      effect->add_forces(state, now.force);
    }
    if (want == Want::energy) now.potential = energy;
  }
  now.acceleration = largest_acceleration(model_.bodies, now.force, *team_);
}

double Gas::seconds_of_forces(const Effect& effect) {
  const State now = state();
  std::vector<double> force(model_.bodies.momentum.size());
  double seconds = 0;
  {
    const Stopwatch stopwatch(seconds);
    effect.add_forces(now, force);
  }
  return seconds;
}

void Gas::add_impulse(double dt, std::span<const double> force) {
  for (std::size_t k = 0; k < force.size(); ++k) model_.bodies.momentum[k] += dt * force[k];
}

bool Gas::has_smooth_forces() const {
  return std::ranges::any_of(model_.effects,
                             [](const auto& effect) { return effect->kind().make.overrides().add_forces; });
}

void Gas::drive(Instant& now, double begin, double dt) {
  if (in_elastic_stage()) return;
  bool driven = false;
  for (const auto& effect : model_.effects) {
    std::vector<double> momentum_change;
    if (effect->kind().make.overrides().drive) momentum_change = model_.bodies.momentum;
    const std::optional<double> given = effect->drive(begin, dt, model_.bodies);
    if (!given) continue;
    budget_.driven += *given;
    for (std::size_t k = 0; k < momentum_change.size(); ++k) momentum_change[k] -= model_.bodies.momentum[k];
    now.velocity_change +=
        momentum_change.empty() ? INFINITY : largest_acceleration(model_.bodies, momentum_change, *team_);
    driven = true;
  }
  if (driven) now.statistics = grain_statistics(model_.bodies, *team_);
}

std::span<const Pair> Gas::candidate_pairs(double dt) {
  const Stopwatch stopwatch(seconds_.lists);
  const double speed = fastest();
  try {
    // Twice the largest speed is a bound on speeds after a collision.
    return list_.pairs(model_.bodies, 2 * speed * dt, *team_);
  } catch (const InputError&) {  // beyond the range of pair lists in the box
    refuse_travel(dt, speed, 0);
  }
}

void Gas::refuse_travel(double dt, double fastest, double gain) const {
  throw Failure(fmt::format(
      "{}: from t = {:.6g} t0 on a grain may move {:.3g} d0 within a step of {:.3g} t0, with a speed of up to {:.3g} "
      "v0 and up to {:.3g} v0 more by the forces on it, too far for the box: a shorter mechanics.step, smaller "
      "charges, a smaller effects.coulomb.coupling_constant or a larger domain.size is needed",
      scene_.path, time_, 2 * (fastest + gain) * dt, dt, fastest, gain));
}

ContactLoad Gas::contact_load(std::span<const Pair> pairs) {
  const Stopwatch stopwatch(seconds_.contacts);
  return granular::contact_load(law_, model_.bodies, pairs);
}

double Gas::fastest_impact(const Instant& now) const {
  const double impact = 2 * now.statistics.fastest;
  constexpr double rounding = 1e-6;
  if (now.release && (1 + rounding) * *now.release < impact) return impact;
  return std::max(impact, rough_ ? rough_->fastest_release(model_.bodies, contacts_)
                                 : fastest_release(law_, model_.bodies, contacts_));
}

double Gas::speed_to_follow(const Instant& now) const {
  return has_smooth_forces() || rough_ ? now.statistics.fastest : 0.5 * fastest_impact(now);
}

ContactsFollowed Gas::advance_contacts(const Instant& now, double dt, int times, double gain) {
  const double fastest = speed_to_follow(now);
  const double path = (fastest + gain) * dt / times, allowed_path = 0.5 * longest_travel(model_.bodies);
  // Twice the largest speed is a bound on speeds after a collision.
  if (path > allowed_path) refuse_travel(dt / times, fastest, gain);
  const ContactSteps all{.begin = time_,
                         .time = dt,
                         .steps = times,
                         .fastest = fastest,
                         .velocity_change = now.velocity_change,
                         .gain = gain,
                         .search_path = std::min(path_per_search, allowed_path)};
  const Stopwatch stopwatch(seconds_.contacts);
  ContactsFollowed followed = contact_motion_->advance(model_.bodies, contacts_, now.force, all, *team_);
  searches_ += followed.searches;
  budget_.contact_error += followed.stored_at_end - followed.stored_at_start + followed.rotation;
  return followed;
}

double Gas::time_to_resolve(double impact) const {
  return rough_ ? rough_->time_to_resolve(impact, grain_properties_)
                : granular::time_to_resolve(law_, impact, grain_properties_);
}

int Gas::contact_steps_within(const Instant& now, double dt, double gain) const {
  const double step = time_to_resolve(fastest_impact(now) + 2 * gain) / scene_.mechanics.contact_steps;
  constexpr double most = 1e8;
  if (!(dt / step < most))
    throw Failure(
        fmt::format("{}: at t = {:.6g} t0 the shortest contact or its damping takes {:.2g} t0, too short for steps of "
                    "{:.2g}: softer contacts ({}), or a far shorter mechanics.step, is needed",
                    scene_.path, time_, step * scene_.mechanics.contact_steps, dt,
                    stage_ < scene_.stages.size() ? "equilibration.stiffness, stiffness" : "stiffness"));
  return std::max(1, static_cast<int>(std::ceil(dt / step)));
}

Instant Gas::follow_contacts(const Instant& now, double end, Want want) {
  const double dt = end - time_, gain = now.acceleration * dt;
  const int count = contact_steps_within(now, dt, gain);
  budget_.contact_error -= now.statistics.kinetic;
  ContactsFollowed followed = advance_contacts(now, dt, count, gain);
  Instant then = instant();
  then.release = followed.fastest_release, then.velocity_change = 0;
  budget_.contact_error += then.statistics.kinetic + followed.record.dissipated - followed.work;
  if (!std::isfinite(budget_.contact_error))
    throw Failure(fmt::format("{}: from t = {:.6g} t0 on the grains' positions are not finite", scene_.path, time_));
  wrap(model_.bodies);
  time_ = end;
  contact_steps += count;
  record_step(std::move(followed.record));
  if (now.force.empty()) return then;
  find_forces(then, want);
  const KickResult result = granular::kick(model_.bodies, 0.5 * dt, now.force, then.force, *team_);
  then.velocity_change = result.most, then.statistics = result.after;
  return then;
}

void Gas::move(std::span<const double> path, double time) {
  for (std::size_t k = 0; k < path.size(); ++k) model_.bodies.position[k] += path[k];
  wrap(model_.bodies);
  time_ = time;
}

void Gas::note(std::vector<StepContact> step_contacts, double begin, double dissipated) {
  ContactRecord record{.time = time_, .dt = time_ - begin, .dissipated = dissipated};
  granular::note(std::move(step_contacts), model_.bodies, time_, contacts_, record);
  record.open = contacts_;
  ++contact_steps;
  record_step(std::move(record));
}

void Gas::record_step(ContactRecord record) {
  record_ = std::move(record);
  ++steps;
  collisions += static_cast<std::int64_t>(record_.begun.size());
  largest_overlap = std::max(largest_overlap, record_.largest_overlap);
  restitution.count(record_.ended, model_.bodies, law_, stage_begin());
  budget_.dissipated += record_.dissipated;
}

void Gas::exchange_charges(Instant& now) {
  if (in_elastic_stage()) return;
  std::vector<double> charge = model_.bodies.charge;
  {
    const Stopwatch stopwatch(seconds_.exchange);
    for (const auto& effect : model_.effects) effect->exchange_charges(record_, model_.bodies, charge);
  }
  if (charge == model_.bodies.charge) return;
  const double before = potential_energy(now.potential);
  model_.bodies.charge = std::move(charge);
  now.force.clear(), now.potential.reset();
  find_forces(now, Want::energy);
  budget_.exchanged += potential_energy(now.potential) - before;
}

bool Gas::in_elastic_stage() const { return stage_ < scene_.stages.size() && scene_.stages[stage_].elastic; }

bool Gas::cools_on_after_stage() const {
  return stage_ < scene_.stages.size() && !scene_.stages[stage_].elastic && !scene_.stages[stage_].temperature;
}

double Gas::stage_begin() const {
  double begin = 0;
  for (std::size_t s = 0; s < stage_; ++s) begin += scene_.stages[s].duration;
  return begin;
}

double Gas::stage_end() const {
  double end = 0;
  for (std::size_t s = 0; s <= stage_; ++s) end = s < scene_.stages.size() ? end + scene_.stages[s].duration : INFINITY;
  return end;
}

void Gas::set_law() {
  const GrainContactLaw given = contact_law(scene_, model_);
  law_ = given;
  if (stage_ < scene_.stages.size()) {
    const Stage& stage = scene_.stages[stage_];
    law_ = stage.elastic ? elastic(given, stage.stiffness) : stiffer(given, stage.stiffness);
  }
  if (surface_key(scene_).empty()) {
    contact_motion_ = make_contact_motion(law_, model_.bodies.dimension);
    return;
  }
  SurfaceLaw surface = surface_law(scene_, model_);
  if (surface.walls && stage_ < scene_.stages.size())
    surface.walls = in_stage(*surface.walls, given, scene_.stages[stage_]);
  auto motion = make_rough_motion(law_, in_elastic_stage() ? elastic(surface) : surface, model_.bodies.dimension);
  rough_ = motion.get();
  contact_motion_ = std::move(motion);
  rough_->begin(model_.bodies);
}

Instant Gas::leave_stage(Instant now) {
  const double before = mechanical_energy();
  if (const std::optional<double> temperature = scene_.stages[stage_].temperature) rescale(*temperature);
  ++stage_;
  set_law();
  budget_.driven += mechanical_energy() - before;
  now.statistics = grain_statistics(model_.bodies, *team_), now.release.reset(), now.velocity_change = INFINITY;
  return now;
}

void Gas::rescale(double temperature) {
  Bodies& b = model_.bodies;
  const double now = 2 * kinetic_energy() / (b.dimension * std::max(1, b.size()));
  if (!(now > 0))
    throw Failure(
        fmt::format("{}: equilibration.temperature = {:g} is impossible: all grains are at rest when the stage ends, "
                    "and zero velocities cannot be scaled; give them population.temperature or velocities",
                    scene_.path, temperature));
  for (double& p : b.momentum) p *= std::sqrt(temperature / now);
}

Checkpoint Gas::save() const {
  Checkpoint checkpoint;
  const Bodies& b = model_.bodies;
  checkpoint.reals["time"] = {time_};
  checkpoint.reals["position"] = b.position;
  checkpoint.reals["momentum"] = b.momentum;
  if (!b.charge.empty()) checkpoint.reals["charge"] = b.charge;
  checkpoint.integers["image"].assign(b.image.begin(), b.image.end());
  checkpoint.integers["stage"] = {static_cast<std::int64_t>(stage_)};
  checkpoint.integers["counters"] = {steps, contact_steps, collisions};
  checkpoint.reals["book"] = {budget_.dissipated, budget_.exchanged, budget_.driven, budget_.contact_error,
                              largest_overlap};
  std::vector<std::int64_t>& pairs = checkpoint.integers["contact_pairs"];
  std::vector<double>& touches = checkpoint.reals["contact_touches"];
  for (const GrainContact& c : contacts()) {
    pairs.insert(pairs.end(), {c.pair.i, c.pair.j, c.alone});
    touches.insert(touches.end(), {c.since, c.impact_speed});
  }
  if (!b.inertia.empty()) checkpoint.reals["angular_velocity"] = b.angular_velocity;
  if (rough_) rough_->save(checkpoint);
  restitution.save(checkpoint);
  model_.save(checkpoint);
  return checkpoint;
}

void Gas::restore(const Checkpoint& checkpoint) {
  Bodies& b = model_.bodies;
  const std::size_t components = b.position.size();
  const auto whole = [&](const std::string& name, std::size_t size) -> const std::vector<std::int64_t>& {
    const std::vector<std::int64_t>& values = integers(checkpoint, name);
    if (values.size() != size)
      throw Failure("the checkpoint's " + name + " are not those of this scene: another version of it wrote them");
    return values;
  };
  time_ = reals(checkpoint, "time", 1).front();
  b.position = reals(checkpoint, "position", components);
  b.momentum = reals(checkpoint, "momentum", components);
  if (!b.charge.empty()) b.charge = reals(checkpoint, "charge", b.charge.size());
  const auto& image = whole("image", components);
  b.image.assign(image.begin(), image.end());
  stage_ = static_cast<std::size_t>(whole("stage", 1)[0]);
  if (stage_ > scene_.stages.size())
    throw Failure(
        fmt::format("the checkpoint is of a stage that this scene, with {}, does not have", scene_.stages.size()));
  const auto& counters = whole("counters", 3);
  steps = counters[0], contact_steps = counters[1], collisions = counters[2];
  const std::vector<double>& budget = reals(checkpoint, "book", 5);
  budget_ = {.dissipated = budget[0], .exchanged = budget[1], .driven = budget[2], .contact_error = budget[3]};
  largest_overlap = budget[4];
  restitution.restore(checkpoint);
  const std::vector<std::int64_t>& pairs = integers(checkpoint, "contact_pairs");
  const std::vector<double>& touches = reals(checkpoint, "contact_touches", pairs.size() / 3 * 2);
  contacts_.clear();
  if (pairs.size() % 3 != 0) throw Failure("the checkpoint has a contact without two grains and a mark");
  for (std::size_t k = 0; k < pairs.size(); k += 3)
    if (const auto [low, high] = std::minmax(pairs[k], pairs[k + 1]); low < 0 || low == high || high >= b.size())
      throw Failure(fmt::format("the checkpoint has a contact of the grains {} and {}: two of 0 to {} are needed", low,
                                high, b.size() - 1));
  for (std::size_t k = 0; 3 * k < pairs.size(); ++k)
    contacts_.push_back({{static_cast<int>(pairs[3 * k]), static_cast<int>(pairs[3 * k + 1])},
                         touches[2 * k],
                         touches[2 * k + 1],
                         pairs[3 * k + 2] != 0});
  if (!b.inertia.empty()) b.angular_velocity = reals(checkpoint, "angular_velocity", b.angular_velocity.size());
  set_law();
  if (rough_) rough_->restore(checkpoint);
  model_.restore(checkpoint);
}

}  // namespace lichtenberg::granular
