#include "src/commands/explain_grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "src/commands/device.hpp"
#include "src/commands/gas_parameters.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/slow_force_limits.hpp"
#include "src/granular/summary.hpp"
#include "src/scene/contact_steps.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/grains.hpp"
#include "src/scene/si.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg {
namespace {

/// Returns the volume (area) fraction of the grains.
double grain_filling(const Scene& scene) {
  double sum = 0;
  for (const Conductor& grain : scene.conductors)
    sum += scene.dimension() == 3 ? 4.0 / 3 * std::pow(grain.radius, 3) : std::pow(grain.radius, 2);
  return std::numbers::pi * sum * grain_density(scene) / static_cast<double>(scene.conductors.size());
}

void explain_sums(Explanation& out, const Scene& scene) {
  Vec3 momentum{};
  double charge = 0, squares = 0, largest = 0;
  for (const Conductor& grain : scene.conductors) {
    momentum +=
        (4.0 / 3 * std::numbers::pi * scene.material.density * grain.material.density * std::pow(grain.radius, 3)) *
        grain.velocity;
    charge += grain.charge, squares += grain.charge * grain.charge;
    largest = std::max(largest, std::abs(grain.charge));
  }
  out.print("  momentum             {:.1e} m0 v0 in total\n", norm(momentum));
  if (largest > 0)
    out.print("  charges              {:.4g} q0 in total, rms {:.4g}, at most {:.4g}\n", charge,
              std::sqrt(squares / static_cast<double>(scene.conductors.size())), largest);
}

double smallest_mass(const Scene& scene) {
  double smallest = INFINITY;
  for (const Conductor& grain : scene.conductors)
    smallest = std::min(smallest, grain.material.density * std::pow(grain.radius, 3));
  return 4.0 / 3 * std::numbers::pi * scene.material.density * smallest;
}

granular::GrainProperties grain_properties(const Scene& scene) {
  return {smallest_mass(scene), scene.smallest_radius(), granular::typical_impact(scene.conductors.size())};
}

/// Returns the expected largest speed of grains with the smallest mass at this temperature.
double fastest_speed(const Scene& scene, double temperature) {
  return granular::fastest_of(scene.conductors.size()) * std::sqrt(temperature / smallest_mass(scene));
}

/// Returns the mean contact duration times the collision frequency at this temperature.
double crowding(const Scene& scene, const GrainContactLaw& law, double temperature) {
  const auto duration = [&](double speed, double) { return contact_duration(law, speed); };
  return theory::collision_frequency(grain_density(scene), temperature) * theory::impact_mean(temperature, duration);
}

/// Returns the criterion that sets the number of contact substeps, and their error.
std::string reason_of_steps(const Scene& scene) {
  const int steps = scene.mechanics.contact_steps;
  const std::optional<double> accuracy = least_in(scene, &StepLimits::force_accuracy);
  const double factor = contact_error_factor(scene);
  const std::string error = fmt::format("error of about {:.1g} of a contact's energy", factor * contact_error(steps));
  if (steps != contact_steps_for(accuracy.value_or(usual_contact_accuracy) / factor))
    return error + ": mechanics.contact_substeps";
  if (steps == fewest_contact_steps) return error + ", the minimum";
  return error + (accuracy ? fmt::format(", for forces to {:g}", *accuracy) : "");
}

void explain_contacts(Explanation& out, const Scene& scene, const GrainContactLaw& law, double temperature) {
  const double speed = 2 * fastest_speed(scene, temperature),
               shortest = granular::time_to_resolve(elastic(law, 1), speed, grain_properties(scene));
  const double resolved = granular::time_to_resolve(law, speed, grain_properties(scene));
  const std::string more =
      resolved < shortest ? fmt::format(" in each {:.3g} t0, for its strong damping", resolved) : "";
  out.print("  contacts             the shortest lasts {:.3g} t0 at the start: {} steps{}{}\n", shortest,
            scene.mechanics.contact_steps, more,
            scene.mechanics.integrator->reads("contact_substeps") ? ", " + reason_of_steps(scene) : "");
  out.print("  restitution          {:.4f}, {:.4f}, {:.4f} at the speeds .01, 1 and {:.3g}\n", restitution(law, 0.01),
            restitution(law, 1), restitution(law, 2 * std::sqrt(temperature)), 2 * std::sqrt(temperature));
  if (scene.dimension() == 2) return;
  const double part = crowding(scene, law, temperature);
  out.print("  contact time         a contact lasts {:.2g} times the time between collisions{}\n", part,
            part > 0.05 ? ": collisions of three grains are frequent, which theory neglects; grains charge more" : "");
}

/// Returns the impact speed at which two elastic grains of mass 1 reach this overlap. The stored energy is then m_eff
/// v^2 / 2.
double speed_of_overlap(const GrainContactLaw& law, double overlap) {
  const auto stored = [&](const auto& one) { return one.parts(overlap).stored; };
  return 2 * std::sqrt(std::visit(stored, law));
}

/// Prints the temperature up to which impacts stay above the closest permitted distance of polarizable grains.
void explain_polarization(Explanation& out, const Scene& scene, const GrainContactLaw& law) {
  const std::optional<double> closest = number_in(scene, &EffectKind::closest_approach);
  if (!closest) return;
  const double speed = speed_of_overlap(law, 1 - *closest);
  // The fastest of N impacts has about v_n^2 = 4 T ln N.
  const double limit = speed * speed / (4 * std::log(std::max<double>(2, scene.conductors.size())));
  out.print(
      "  polarization         mutual polarization of two grains diverges closer than {:.2g} d0, which impacts at "
      "{:.3g} v0\n                       may reach: safe below T = {:.2g}; above, use a [[equilibration]] of stiffer "
      "contacts\n",
      *closest, speed, limit);
}

/// Predictions of theory for a homogeneous gas without forces between charges, at equal intervals after the warm-up.
/// The equilibration stages count at the initial temperature.
struct TheoryPrediction {
  std::vector<double> time, temperature;
  std::vector<double> charge;  ///< largest charge of a grain
  double collisions = 0;       ///< per grain
};

/// Returns the mean square of the charge transferred in an impact of a given speed; empty if theory does not provide
/// it.
std::function<double(double)> charge_of_impacts(const Scene& scene) {
  const auto* exchange = scene.effects.find<effects::ChargeExchangeOptions>();
  if (!exchange || exchange->model != effects::ExchangeModel::impact) return {};
  return [=](double speed) { return theory::impact_charge_square(exchange->strength, exchange->exponent, 0.5, speed); };
}

/// Returns the expected largest charge of `grains` grains that charge in collisions. Their distribution is proportional
/// to exp(-sqrt(2) |q| / rms), with kurtosis 6.
double largest_charge(double square, std::size_t grains) {
  return std::sqrt(square / 2) * std::log(std::max<double>(2, static_cast<double>(grains)));
}

TheoryPrediction predict_gas(const Scene& scene, const GrainContactLaw& law) {
  const double warm = warm_up(scene);
  const double left = std::max(scene.stop.time - warm, 0.0), initial = initial_temperature(scene);
  constexpr int intervals = 200;
  TheoryPrediction result;
  for (int k = 0; k <= intervals; ++k) result.time.push_back(left * k / intervals);
  double prescribed_charge = 0;
  for (const Conductor& grain : scene.conductors)
    prescribed_charge = std::max(prescribed_charge, std::abs(grain.charge));
  if (initial <= 0 || scene.dimension() == 2) {
    result.temperature.assign(result.time.size(), initial);
    result.charge.assign(result.time.size(), prescribed_charge);
    return result;
  }
  const theory::Impacts impacts{.restitution = [&](double speed) { return restitution(law, speed); },
                                .charge_square = charge_of_impacts(scene)};
  const auto states = theory::cool(grain_density(scene), impacts, initial, result.time);
  for (const theory::CoolingState& state : states) {
    result.temperature.push_back(state.temperature);
    result.charge.push_back(prescribed_charge + largest_charge(state.charge_square, scene.conductors.size()));
  }
  result.collisions = states.back().collisions + warm * theory::collision_frequency(grain_density(scene), initial);
  return result;
}

/// Work of a whole run.
struct Work {
  double steps = 0, contact_steps = 0;
  double evaluations = 0;  ///< of the forces between charges
  double path = 0;         ///< path of the fastest grain, d0
};

/// Counts the work of multirate without its acceleration techniques. Elastic contacts transfer no charge and need no
/// new evaluation of forces.
Work count_work(const Scene& scene, const GrainContactLaw& law, const TheoryPrediction& prediction) {
  const double note = std::min(0.1 * scene.output.every, scene.stop.time);  // a run stops at these instants
  const granular::GrainProperties grains = grain_properties(scene);
  const ContactAttraction attraction = granular::contact_attraction(scene);
  Work work;
  const auto add = [&](double duration, double temperature, double charge, const GrainContactLaw& stage_law,
                       double force_evaluations) {
    const double speed = fastest_speed(scene, std::max(temperature, 1e-12));
    const double inner = granular::time_to_resolve(stage_law, 2 * speed, grains) / scene.mechanics.contact_steps;
    const double longest = granular::longest_step_within(
        {.requested = scene.mechanics.step,
         .stability_limit = granular::max_outer_step(attraction, stage_law, charge, smallest_mass(scene)),
         .path = granular::path_in_step(scene),
         .speed = speed},
        [&](double) { return inner; });
    const double step = note / std::ceil(note / longest), steps = duration / step;
    work.steps += steps;
    work.contact_steps += steps * std::ceil(step / inner);
    work.evaluations += steps * force_evaluations;
    work.path += speed * duration;
  };
  for (const Stage& stage : scene.stages)
    if (stage.elastic)
      add(stage.duration, initial_temperature(scene), prediction.charge.front(), elastic(law, stage.stiffness), 1);
  double evaluations = 1;
  for (const Effects::Entry& effect : scene.effects)
    if (const auto number = effect.kind->cost.evaluations_a_step) evaluations = std::max(evaluations, number(scene));
  for (std::size_t k = 1; k < prediction.time.size(); ++k)
    add(prediction.time[k] - prediction.time[k - 1],
        std::sqrt(prediction.temperature[k - 1] * prediction.temperature[k]), prediction.charge[k], law, evaluations);
  return work;
}

/// Returns the criterion that limits the first step.
std::string step_criterion(const granular::Gas& gas, double step) {
  const Scene& scene = gas.scene();
  if (step == scene.mechanics.step) return "mechanics.step";
  if (step == granular::max_outer_step(gas)) return "longer steps would excite oscillations of grains bound by charges";
  if (!std::isinf(scene.mechanics.step))
    return fmt::format("the fastest grain flies {:.2g} d0", granular::path_by_length(scene));
  const double max_path = granular::path_by_accuracy(scene);
  if (step * gas.fastest() > 1.001 * max_path) return "forces are computed in each contact substep";
  const double accuracy = least_in(scene, &StepLimits::force_accuracy).value();
  return fmt::format("the fastest grain flies {:.2g} d0, an error equal to that of forces to {:g}", max_path, accuracy);
}

/// Prints the integrator's choices at the start of a run. Throws InputError for a step that a run refuses.
void explain_integrator(Explanation& out, granular::Gas& gas) {
  const Scene& scene = gas.scene();
  const double requested_step = scene.mechanics.step;
  granular::Instant now = gas.instant();
  const double contact = gas.time_to_resolve(gas.fastest_impact(now)) / scene.mechanics.contact_steps;
  // This avoids computing the forces at the start, which are not needed otherwise.
  const auto by_path = [&] {
    return granular::longest_step_within({.stability_limit = granular::max_outer_step(gas),
                                          .path = granular::path_in_step(scene),
                                          .speed = gas.fastest()},
                                         [&](double) { return contact; });
  };
  const double step = std::isinf(requested_step)
                          ? by_path()
                          : granular::make_integrator(scene.mechanics.integrator)->longest_step(gas, now);
  out.print("  integrator           {}, steps {}\n", name_of(scene.mechanics.integrator),
            !std::isinf(requested_step) ? fmt::format("of at most {:g} t0", requested_step)
            : only_contacts_act(scene)  ? std::string("as long as a list of near pairs: only contacts act")
                                        : std::string("chosen by the accuracy of forces"));
  if (!scene.mechanics.integrator->reads("contact_substeps") || !gas.has_smooth_forces()) return;
  if (std::isinf(step)) return;  // no motion
  out.print("  constant forces      for {:.0f} contact substeps at the start, {:.2g} t0: {}\n",
            std::max(1.0, std::ceil(step / contact)), step, step_criterion(gas, step));
}

void explain_stages(Explanation& out, const Scene& scene) {
  for (const Stage& stage : scene.stages)
    out.print("  stage                {:g} t0{}{}\n", stage.duration,
              fmt::format("{}, contacts {:g} times as stiff", stage.elastic ? ", elastic" : "", stage.stiffness),
              stage.temperature ? fmt::format(", then scaled to T = {:g}", *stage.temperature) : "");
  if (const std::string warning = granular::stages_warning(scene); !warning.empty())
    out.print("  WARNING              {}\n", warning);
}

/// Prints the memory, from the largest resident size of runs of 3e5 to 1e7 grains on one core. Their charges had an
/// accuracy of 1e-4 (docs/measurements/benchmarks-gas.json).
void explain_memory(Explanation& out, const Scene& scene) {
  constexpr double at_start = 60e6, grain = 660;  // bytes
  double each = grain;
  for (const Effects::Entry& effect : scene.effects) each += effect.kind->cost.bytes;
  const double bytes = at_start + each * static_cast<double>(scene.conductors.size());
  out.add("memory", bytes, "B");
  out.print("  memory               some {:.0f} MiB\n", bytes / (1 << 20));
}

/// Times of contacts and forces on the processors that this program is compiled for, relative to the reference core
/// with AVX-512.
struct Slowdown {
  double contacts, forces;
};

/// Returns the factors measured on an AMD EPYC without AVX-512 (docs/measurements/benchmarks-gas.json).
/// Contacts: neutral gas, 3.2 s instead of 2.0 s. Forces of charges: a step of 50016 grains, factor 4. Forces of
/// dipoles: polarized gas, 9.9 s instead of 4.2 s, contacts subtracted.
Slowdown slowdown_of(const Scene& scene) {
#if defined(__AVX512F__)
  constexpr bool wide = true;
#else
  constexpr bool wide = false;
#endif
  if (wide) return {1, 1};
  return {.contacts = 1.6, .forces = scene.effects.has("induced_dipoles") ? 2.3 : 4};
}

/// Returns the time (s) per grain for the forces of all effects on the reference core. `slowdown`: factors of this
/// machine.
double seconds_of_forces(granular::Gas& gas, const Slowdown& slowdown) {
  double seconds = 0;
  for (const auto& effect : std::as_const(gas).model().effects) {
    const EffectKind& kind = effect->kind();
    if (kind.cost.seconds) seconds += kind.cost.seconds(gas.scene());
    if (!kind.cost.seconds && kind.make.overrides().add_forces)
      seconds += gas.seconds_of_forces(*effect) / (slowdown.forces * gas.bodies().size());
  }
  return seconds;
}

/// Prints the cost from measurements on one otherwise idle core of an AMD EPYC with AVX-512
/// (docs/measurements/benchmarks-gas.json).
void explain_cost(Explanation& out, granular::Gas& gas, const Work& work) {
  const Scene& scene = gas.scene();
  // Times in s per grain: a contact substep; changes of pairs and neighbour lists, per d0 of the fastest grain's path;
  // passes over all grains, per step.
  constexpr double contact_step = 3.6e-8, path_cost = 5e-7, step = 1.5e-8;
  // Time of forces in a run relative to isolated evaluations. Contacts displace cached data, the energy record needs
  // potentials, and grains in clusters have more neighbours.
  constexpr double in_run_factor = 1.5;
  const double n = static_cast<double>(scene.conductors.size());
  const Slowdown slowdown = slowdown_of(scene);
  const double contacts = slowdown.contacts * n * (work.contact_steps * contact_step + work.path * path_cost);
  const double forces = slowdown.forces * n * work.evaluations * in_run_factor * seconds_of_forces(gas, slowdown);
  const double seconds = contacts + forces + slowdown.contacts * n * work.steps * step;
  out.add("steps", work.steps, "1");
  out.add("contact_steps", work.contact_steps, "1");
  out.add("run_time", seconds, "s");
  out.print("\ncost: an estimate for one core, of a gas that stays homogeneous\n");
  out.print("  steps                {:.2g}, {:.2g} of contacts\n", work.steps, work.contact_steps);
  out.print("  a run                {:.2g} s: {:.2g} s of contacts", seconds, contacts);
  if (forces > 0) out.print(", {:.2g} s of smooth forces, {:.2g} times", forces, work.evaluations);
  out.print("\n");
}

/// Prints the memory of a gas on CUDA devices, the grains that fit on an H200, and the gain by several devices.
void explain_device(Explanation& out, const Scene& scene, int devices) {
  constexpr double mebibyte = 1 << 20, h200 = 140 * 1024 * mebibyte;
  const double bytes = granular::device::bytes_needed(scene), grains = static_cast<double>(scene.conductors.size());
  out.print(
      "  device               cuda: some {:.0f} MiB of {}; an H200 (140 GiB) has space for {:.2g} of these grains\n",
      bytes / mebibyte, devices == 1 ? "its memory" : "the memory of each", grains * h200 / bytes);
  if (devices == 1) return;
  const double gain = granular::device::expected_gain(scene.conductors.size(), devices);
  out.add("device_gain", gain, "1");
  out.print("  {:<21}some {:.1f} times the speed of one, less for many contact steps (from runs on two H200s)\n",
            fmt::format("{} devices", devices), gain);
}

}  // namespace

void explain_grains(Explanation& out, const Scene& scene) {
  const int devices = is_for_cuda(scene) ? static_cast<int>(granular::device::chosen_devices(scene).size()) : 1;
  if (is_for_cuda(scene)) granular::device::check_scene(scene, granular::device::Target::cuda, devices);
  granular::Gas gas(scene);
  const GrainContactLaw law = granular::contact_law(scene, std::as_const(gas).model());
  const TheoryPrediction prediction = predict_gas(scene, law);
  const double initial = initial_temperature(scene);
  const auto [length, mass, velocity, charge] = *scene.reference;
  out.print("\nmotion\n");
  out.print("  units                d0 = {:g} m, m0 = {:g} kg, v0 = {:g} m/s, q0 = {:g} C, t0 = {:g} s{}\n", length,
            mass, velocity, charge, length / velocity, scene.in_si ? ", chosen for this scene in SI" : "");
  if (scene.in_si)
    out.print("  charges              K = {:.4g}, k_e q0^2/(m0 v0^2 d0)\n", coupling_constant(*scene.reference));
  out.add("filling", grain_filling(scene), "1");
  out.print("  filling              {:.4f} of the box\n", grain_filling(scene));
  explain_sums(out, scene);
  explain_stages(out, scene);
  explain_integrator(out, gas);
  explain_memory(out, scene);
  if (is_for_cuda(scene)) explain_device(out, scene, devices);
  if (initial > 0) explain_contacts(out, scene, law, initial);
  explain_polarization(out, scene, law);
  if (prediction.collisions > 0 && surface_key(scene).empty())
    out.print("  theory               T = {:.3g} at the end, {:.3g} collisions a grain, if it stays homogeneous\n",
              prediction.temperature.back(), prediction.collisions);
  if (scene.mechanics.integrator->reads("contact_substeps")) explain_cost(out, gas, count_work(scene, law, prediction));
}

}  // namespace lichtenberg
