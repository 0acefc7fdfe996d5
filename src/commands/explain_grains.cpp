#include "src/commands/explain_grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/error.hpp"
#include "src/effects/effects.hpp"
#include "src/granular/contacts.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/restitution.hpp"

namespace lichtenberg {
namespace {

double density(const Scene& scene) {
  double volume = 1;
  for (int k = 0; k < scene.dimension(); ++k) volume *= scene.domain.size[k];
  return static_cast<double>(scene.conductors.size()) / volume;
}

/// Part of the box that the grains fill.
double filling(const Scene& scene) {
  double sum = 0;
  for (const Conductor& grain : scene.conductors)
    sum += scene.dimension() == 3 ? 4.0 / 3 * std::pow(grain.radius, 3) : std::pow(grain.radius, 2);
  return std::numbers::pi * sum * density(scene) / static_cast<double>(scene.conductors.size());
}

/// What the grains' velocities are the temperature of, at the start of what is not a stage.
double initial_temperature(const Scene& scene) {
  for (auto stage = scene.stages.rbegin(); stage != scene.stages.rend(); ++stage)
    if (stage->temperature) return *stage->temperature;
  double sum = 0;
  for (const Conductor& grain : scene.conductors)
    sum += 4.0 / 3 * std::numbers::pi * scene.material.density * std::pow(grain.radius, 3) * norm2(grain.velocity);
  return sum / (scene.dimension() * static_cast<double>(scene.conductors.size()));
}

double restitution_of(const ViscoelasticLaw& law, double speed) {
  if (law.dissipative == 0) return 1;
  const theory::ViscoelasticPair pair{law.elastic, law.dissipative};
  const double k = std::min(theory::dissipation_number(pair, speed), theory::RestitutionCurve::largest);
  return 1 - k * theory::restitution_curve()(k).loss;
}
double restitution_of(const LinearSpringLaw& law, double) { return linear_collision(law, 0.5).restitution; }

double restitution(const GrainContactLaw& law, double speed) {
  return std::visit([&](const auto& one) { return restitution_of(one, speed); }, law);
}

/// Temperatures of a homogeneous gas without charges at equal intervals, the stages' part taken as at the start.
struct Foreseen {
  std::vector<double> time, temperature;
  double collisions = 0;  ///< of a grain
};

Foreseen foresee(const Scene& scene, const GrainContactLaw& law) {
  double warm = 0;
  for (const Stage& stage : scene.stages) warm += stage.duration;
  const double left = std::max(scene.stop.time - warm, 0.0), initial = initial_temperature(scene);
  constexpr int intervals = 200;
  Foreseen result;
  std::vector<double> times;
  for (int k = 0; k <= intervals; ++k) times.push_back(left * k / intervals);
  const theory::Impacts impacts{.restitution = [&](double speed) { return restitution(law, speed); }};
  result.time = times;
  if (initial <= 0 || scene.dimension() == 2) {
    result.temperature.assign(times.size(), initial);
    return result;
  }
  const auto states = theory::cool(density(scene), impacts, initial, times);
  for (const theory::CoolingState& state : states) result.temperature.push_back(state.temperature);
  result.collisions = states.back().collisions + warm * theory::collision_frequency(density(scene), initial);
  return result;
}

/// Speed of the fastest of so many Maxwellian grains over sqrt(T): the tail sqrt(2/pi) u exp(-u^2/2) holds one of them.
double fastest(std::size_t grains) {
  double u = 3;
  for (int k = 0; k < 20; ++k) u = std::sqrt(2 * std::log(static_cast<double>(grains) * std::max(u, 1.0) * 0.8));
  return u;
}

struct Steps {
  double outer = 0, contact = 0;
};

Steps count_steps(const Scene& scene, const GrainContactLaw& law, const Foreseen& foreseen) {
  constexpr double path = 0.2;  // granular::Multirate's
  Steps steps;
  const auto add = [&](double duration, double temperature, const GrainContactLaw& then) {
    const double speed = fastest(scene.conductors.size()) * std::sqrt(std::max(temperature, 1e-12));
    const double outer = std::min(scene.mechanics.step, path / speed);
    const double inner = shortest_contact(then, 2 * speed) / scene.mechanics.contact_steps;
    steps.outer += duration / outer;
    steps.contact += duration / outer * std::ceil(outer / inner);
  };
  for (const Stage& stage : scene.stages)
    add(stage.duration, initial_temperature(scene), stage.elastic ? elastic(law, stage.stiffness) : law);
  for (std::size_t k = 1; k < foreseen.time.size(); ++k)
    add(foreseen.time[k] - foreseen.time[k - 1], foreseen.temperature[k], law);
  return steps;
}

void explain_stages(const Scene& scene) {
  for (const Stage& stage : scene.stages)
    fmt::print("  stage                {:g} t0{}{}\n", stage.duration,
               stage.elastic ? fmt::format(", elastic, contacts {:g} times as stiff", stage.stiffness) : "",
               stage.temperature ? fmt::format(", then scaled to T = {:g}", *stage.temperature) : "");
}

void explain_cost(const Scene& scene, const Steps& steps) {
  // One core of an AMD EPYC (validation/benchmarks/README.md).
  constexpr double contact_step = 1e-7, lists = 1.5e-7;  // s a grain
  const double n = static_cast<double>(scene.conductors.size());
  double evaluation = 0;
  for (const Effects::Entry& effect : scene.effects) evaluation += effect.kind->seconds;
  const double evaluations = scene.effects.has(&EffectKind::exchanges_charge) ? 2 * steps.outer : steps.outer;
  fmt::print("\ncost: an estimate, from figures measured on one core\n");
  fmt::print("  steps                {:.2g}, {:.2g} of contacts\n", steps.outer, steps.contact);
  fmt::print("  a run                {:.2g} s\n",
             n * (steps.contact * contact_step + steps.outer * lists + evaluations * evaluation));
}

}  // namespace

void explain_grains(const Scene& scene) {
  const GrainContactLaw law = granular::contact_law(scene, effects::make_model(scene));
  const Foreseen foreseen = foresee(scene, law);
  const double initial = initial_temperature(scene);
  const auto [length, mass, velocity, charge] = *scene.reference;
  fmt::print("\nmotion\n");
  fmt::print("  units                d0 = {:g} m, m0 = {:g} kg, v0 = {:g} m/s, q0 = {:g} C, t0 = {:g} s\n", length,
             mass, velocity, charge, length / velocity);
  fmt::print("  filling              {:.4f} of the box\n", filling(scene));
  explain_stages(scene);
  fmt::print("  integrator           {}, steps of at most {:g} t0\n", name_of(scene.mechanics.integrator),
             scene.mechanics.step);
  if (initial > 0) {
    const double speed = 2 * fastest(scene.conductors.size()) * std::sqrt(initial);
    fmt::print("  contacts             the shortest lasts {:.3g} t0 at the start: {} steps\n",
               shortest_contact(law, speed), scene.mechanics.contact_steps);
    fmt::print("  restitution          {:.4f}, {:.4f}, {:.4f} at the speeds .01, 1 and {:.3g}\n",
               restitution(law, 0.01), restitution(law, 1), restitution(law, 2 * std::sqrt(initial)),
               2 * std::sqrt(initial));
  }
  if (foreseen.collisions > 0)
    fmt::print("  theory               T = {:.3g} at the end, {:.3g} collisions a grain, if it stays homogeneous\n",
               foreseen.temperature.back(), foreseen.collisions);
  if (scene.mechanics.integrator == Integrator::multirate) explain_cost(scene, count_steps(scene, law, foreseen));
}

}  // namespace lichtenberg
