#include "src/model/model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "solvers/error.hpp"
#include "src/model/checkpoint.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {

std::string_view Effect::name() const { return kind().name; }

void Effect::mark_interacting(const Bodies&, std::span<const double>, std::vector<bool>& interacting) const {
  if (kind().make.overrides().add_forces) interacting.assign(interacting.size(), true);
}

namespace {

/// Appends the block along * n n' + across * (1 - n n') in the rows of body i and the columns of body j.
void append(std::vector<ForceJacobian::Entry>& entries, int i, int j, std::span<const double> n, double along,
            double across) {
  const int d = static_cast<int>(n.size());
  for (int k = 0; k < d; ++k)
    for (int l = 0; l < d; ++l)
      entries.push_back({i * d + k, j * d + l, (along - across) * n[k] * n[l] + (k == l) * across});
}

void refuse_namesakes(const std::vector<std::unique_ptr<Effect>>& effects) {
  std::set<std::string_view> names;
  for (const auto& effect : effects)
    if (!names.insert(effect->name()).second)
      throw InputError(fmt::format(
          "two effects are named \"{}\": their names must differ, because they identify the effects in a checkpoint",
          effect->name()));
}

void check_one_a_body(const std::vector<double>& charge, const Bodies& bodies, const Effect& effect) {
  if (charge.size() != static_cast<std::size_t>(bodies.size()))
    throw InputError(fmt::format("effects.{} needs {} charges, one for each body, but is given {}", effect.name(),
                                 bodies.size(), charge.size()));
}

/// Returns the skin (m) of the neighbour list: a compromise between few rebuilds and few pairs beyond the range. Range,
/// skin and two radii together stay below half a periodic box.
double skin_for(const Bodies& bodies, double range) {
  constexpr double usual = 0.8;  // fraction of the largest radius
  const double radius = *std::ranges::max_element(bodies.radius);
  double half = INFINITY;
  for (int k = 0; k < bodies.dimension; ++k)
    if (bodies.box.periodic(k)) half = std::min(half, 0.5 * bodies.box.lengths[k]);
  return std::clamp(half * (1 - 1e-9) - range - 2 * radius, 0.0, usual * radius);
}

std::string prefix_of(const Effect& effect) { return "effects." + std::string(effect.name()) + "."; }

template <class Arrays>
void put(const Arrays& own, const std::string& prefix, Arrays& all) {
  for (const auto& [name, values] : own) all[prefix + name] = values;
}

template <class Arrays>
Arrays taken(const Arrays& all, const std::string& prefix) {
  Arrays own;
  for (auto at = all.lower_bound(prefix); at != all.end() && at->first.starts_with(prefix); ++at)
    own[at->first.substr(prefix.size())] = at->second;
  return own;
}

}  // namespace

void ForceJacobian::add_central(int i, int j, std::span<const double> n, double along, double across) {
  append(by_position, i, j, n.first(dimension_), along, across);
}

void ForceJacobian::add_drag(int i, std::span<const double> n, double along, double across) {
  append(by_momentum, i, i, n.first(dimension_), along, across);
}

void ForceJacobian::add_drag(int i, double rate) {
  for (int k = 0; k < dimension_; ++k) by_momentum.push_back({i * dimension_ + k, i * dimension_ + k, rate});
}

Model::Model(Bodies b, std::vector<std::unique_ptr<Effect>> e, const std::vector<double>& charge)
    : bodies(std::move(b)), effects(std::move(e)), drag(bodies.size()), drag_at_(effects.size()) {
  refuse_namesakes(effects);
  const bool periodic = visit_spheres(bodies, [](const auto& s) { return s.box.any_periodic(); });
  std::optional<double> range;
  for (const auto& effect : effects) {
    effect->kind().check_dimension(bodies.dimension);
    if (periodic) effect->kind().check_periodic();
    const Needs needs = effect->needs();
    if (needs.charges) check_one_a_body(charge, bodies, *effect), bodies.charge = charge;
    if (needs.neighbour_range) range = std::max(*needs.neighbour_range, range.value_or(*needs.neighbour_range));
  }
  for (std::size_t k = 0; k < effects.size(); ++k) add_drag_of(k);
  if (range && bodies.size() > 0) neighbours.emplace(*range, skin_for(bodies, *range));
}

namespace {

/// Throws InputError if an effect has given two laws of drag for two velocities of a body.
void check_independence(const Effect& effect, const DragLaw& law, const DragLaw& other) {
  bool is_same =
      law.linear == other.linear && !law.nonlinear == !other.nonlinear && !law.by_position == !other.by_position;
  for (double speed = 1e-6; is_same && law.nonlinear && speed < 100; speed *= 10)  // the speeds of Drag::add
    is_same = law.nonlinear(speed).force == other.nonlinear(speed).force;
  if (!is_same)
    throw InputError(
        fmt::format("effects.{}: Effect::drag depends on the velocity of the body, but it is read once: it must return "
                    "the force as a function of the speed (DragLaw::nonlinear)",
                    effect.name()));
}

}  // namespace

void Model::add_drag_of(std::size_t e) {
  const Effect& effect = *effects[e];
  Bodies moving = bodies;
  for (std::size_t k = 0; k < moving.momentum.size(); ++k)
    moving.momentum[k] += moving.mass[k / bodies.dimension] * 1.0;  // by 1 m/s
  bool drags = false;
  for (int i = 0; i < bodies.size(); ++i) {
    const DragLaw law = effect.drag(bodies, i);
    try {
      drags |= drag.add(i, law);
    } catch (const InputError& error) {
      throw InputError(fmt::format("effects.{}: {}", effect.name(), error.what()));
    }
    check_independence(effect, law, effect.drag(moving, i));
  }
  if (!drags) return;
  if (effect.kind().grains)
    throw InputError(
        fmt::format("effects.{} defines Effect::drag, which is not for grains: it must define Effect::drive instead",
                    effect.name()));
  drag_at_ = std::min(drag_at_, e);
}

bool Model::dissipates() const {
  return std::ranges::any_of(effects, [](const auto& effect) { return effect->needs().dissipates; });
}

double Model::dissipated_power(double time) {
  const State now = state(time);
  double power = 0;
  for (const auto& effect : effects) power += effect->dissipated_power(now);
  return power;
}

double Model::largest_move() const {
  double radii = INFINITY;
  for (const auto& effect : effects) radii = std::min(radii, effect->needs().largest_move.value_or(INFINITY));
  return bodies.size() == 0 ? INFINITY : radii * *std::ranges::min_element(bodies.radius);
}

State Model::state(double time, RequestedBodies& requested) {
  if (!neighbours) return {time, bodies, {}, *team, requested.bodies()};
  return {time, bodies, requested.neighbours(*neighbours, bodies, *team), *team, requested.bodies()};
}

void Model::forces(double time, RequestedBodies& requested, std::span<double> force) {
  const State now = state(time, requested);
  const int d = bodies.dimension;
  for_each_requested(now, [&](int i) { std::fill_n(force.begin() + i * d, d, 0.0); });
  for (std::size_t e = 0; e < effects.size(); ++e) {
    effects[e]->add_forces(now, force);
    if (e == drag_at_) drag.add_forces(now, force);
  }
  if (bodies.fix_z) for_each_requested(now, [&](int i) { force[i * d + 2] = 0; });
}

void Model::jacobian(double time, RequestedBodies& requested, ForceJacobian& jacobian) {
  jacobian.clear();
  const State now = state(time, requested);
  for (std::size_t e = 0; e < effects.size(); ++e) {
    effects[e]->add_jacobian(now, jacobian);
    if (e == drag_at_) drag.add_jacobian(now, jacobian);
  }
}

void Model::currents(double time, std::span<double> current) {
  std::ranges::fill(current, 0.0);
  const State now = state_without_neighbours(time);
  for (const auto& effect : effects) effect->add_currents(now, current);
}

double Model::stored_energy(double time) {
  const State now = state(time);
  double energy = 0;
  for (const auto& effect : effects) energy += effect->stored_energy(now);
  return energy;
}

double Model::charge_relaxation_time() const {
  double all = INFINITY;
  for (const auto& effect : effects) {
    const double time = effect->charge_relaxation_time();
    all = std::isinf(all) ? time : std::isinf(time) ? all : all * time / (all + time);  // rates add up
  }
  return all;
}

void Model::accept(double time, double dt) {
  const State now = state_without_neighbours(time);
  for (const auto& effect : effects) effect->accept(now, dt);
}

void Model::save(Checkpoint& checkpoint) const {
  for (const auto& effect : effects) {
    Checkpoint own;
    effect->save(own);
    put(own.reals, prefix_of(*effect), checkpoint.reals);
    put(own.integers, prefix_of(*effect), checkpoint.integers);
  }
}

void Model::restore(const Checkpoint& checkpoint) {
  for (const auto& effect : effects)
    effect->restore({taken(checkpoint.reals, prefix_of(*effect)), taken(checkpoint.integers, prefix_of(*effect))});
}

void Model::add_columns(double time, Frame& frame) {
  const State now = state(time);
  for (const auto& effect : effects) effect->add_columns(now, frame);
}

void Model::summarize(double time, Summary& summary) {
  const State now = state(time);
  for (const auto& effect : effects) effect->summarize(now, summary);
}

double Model::kinetic_energy() const { return lichtenberg::kinetic_energy(bodies); }

}  // namespace lichtenberg
