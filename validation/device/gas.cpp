// A gas of grains on a CUDA device: difference from the CPU's result after one step, time per step, and energy balance.
// The scene's equilibration stages are omitted.
//
//   device_gas scenes/granular-gas-full.toml [--temperature 1] [--charge 1] [--step 0.005] [--steps 400] [--host]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <random>

#include "solvers/error.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/integrator.hpp"
#include "src/scene/contact_steps.hpp"

using namespace lichtenberg;

namespace {

struct Options {
  std::string scene;
  double temperature = 0, charge = 0, step = 0, accuracy = 0, polarizability = 0;
  double tolerance = 1e-4;
  int steps = 400, warm = 50, contact_steps = 0;
  std::vector<int> devices;
  int copies = 1;
  bool host = false, no_exchange = false, no_cpu = false;
};

/// Repeats the periodic box along each axis.
void repeat(Scene& scene, int copies) {
  const std::vector<Conductor> once = scene.conductors;
  const Vec3 size = scene.domain.size;
  scene.conductors.clear();
  for (int k = 0; k < copies * copies * copies; ++k)
    for (Conductor grain : once) {
      grain.position += Vec3{size.x * (k % copies), size.y * (k / copies % copies), size.z * (k / copies / copies)};
      scene.conductors.push_back(grain);
    }
  scene.domain.size = static_cast<double>(copies) * size;
}

Scene prepared(const Options& options) {
  Scene scene = read_scene(options.scene);
  scene.stages.clear();
  if (options.copies > 1) repeat(scene, options.copies);
  scene.stop.time = INFINITY;
  if (options.step > 0) scene.mechanics.step = options.step;
  if (options.contact_steps > 0) scene.mechanics.contact_steps = options.contact_steps;
  if (options.no_exchange) scene.effects.remove("charge_exchange");
  if (auto* coulomb = scene.effects.find<effects::CoulombOptions>(); coulomb && options.accuracy > 0) {
    coulomb->accuracy = options.accuracy;
    if (options.contact_steps == 0) scene.mechanics.contact_steps = contact_steps_for(options.accuracy);
  }
  if (options.polarizability > 0)
    scene.effects.add(
        effects::InducedDipolesOptions{.polarizability = options.polarizability, .tolerance = options.tolerance});
  double sum = 0;
  for (const Conductor& grain : scene.conductors) sum += norm2(grain.velocity);
  const double now = sum / (3 * static_cast<double>(scene.conductors.size()));
  int k = 0;
  for (Conductor& grain : scene.conductors) {
    if (options.temperature > 0) grain.velocity *= std::sqrt(options.temperature / now);
    if (options.charge > 0) grain.charge = k++ % 2 ? options.charge : -options.charge;
  }
  return scene;
}

/// Returns a hash of the bits of a state (FNV-1a).
std::uint64_t hash(const Checkpoint& state) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](std::uint64_t bits) { hash = (hash ^ bits) * 0x100000001b3; };
  for (const auto& [name, values] : state.reals)
    for (const double value : values) add(std::bit_cast<std::uint64_t>(value));
  for (const auto& [name, values] : state.integers)
    for (const std::int64_t value : values) add(static_cast<std::uint64_t>(value));
  return hash;
}

double rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(3 * sum / static_cast<double>(a.size()));
}

void compare(granular::Gas& gas, granular::device::DeviceGas& device) {
  const Checkpoint start = gas.save();
  device.load(start, gas.law(), false, 0, gas.surface());
  const auto integrator = granular::make_multirate();
  granular::Instant now = gas.instant();
  const double end = gas.time() + integrator->longest_step(gas, now);
  integrator->step(gas, std::move(now), end, granular::Want::forces);
  while (device.time() < end) device.step(end);  // rounding may split the step in two
  Checkpoint found = start;
  device.store(found);
  const Checkpoint cpu = gas.save();
  fmt::print(
      "after a step of {:.4f}: positions differ by {:.1e} rms, momenta by {:.1e}, of changes of {:.1e} and {:.1e}; {} "
      "and {} contacts, {} and {} collisions\n",
      end, rms(found.reals["position"], cpu.reals.at("position")),
      rms(found.reals["momentum"], cpu.reals.at("momentum")), rms(start.reals.at("position"), cpu.reals.at("position")),
      rms(start.reals.at("momentum"), cpu.reals.at("momentum")), found.integers["contact_pairs"].size() / 3,
      cpu.integers.at("contact_pairs").size() / 3, found.integers["counters"][2], cpu.integers.at("counters")[2]);
  if (cpu.reals.contains("angular_velocity"))
    fmt::print("angular velocities differ by {:.1e} rms, of changes of {:.1e}\n",
               rms(found.reals["angular_velocity"], cpu.reals.at("angular_velocity")),
               rms(start.reals.at("angular_velocity"), cpu.reals.at("angular_velocity")));
  gas.restore(start);
}

/// Advances as runs do: a hundred steps on the device per call.
void run(granular::device::DeviceGas& device, int steps) {
  constexpr double far = 1e6;
  for (int left = steps; left > 0; left -= 100) device.step(far, std::min(left, 100));
}

/// Runs the gas from the state `start` and returns the state at the end.
Checkpoint measure(granular::Gas& gas, granular::device::DeviceGas& device, const Options& options,
                   const Checkpoint& start) {
  gas.restore(start);
  const granular::GasEnergy before = gas.energy();
  device.load(start, gas.law(), false, 0, gas.surface());
  run(device, options.warm);
  const auto then = device.counts();
  const double time = device.time();
  const auto clock = std::chrono::steady_clock::now();
  run(device, options.steps);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock).count();
  const auto now = device.counts();
  const double steps = static_cast<double>(now.steps - then.steps);
  const double contact_steps = static_cast<double>(now.contact_steps - then.contact_steps);
  fmt::print(
      "{:.0f} steps/s, {:.0f} of contacts/s; {:.1f} us a step, {:.1f} of them lists ({:.2f} a step), {:.1f} steps of "
      "contacts and {:.2f} sums over charges a step; {:.4g} t0/s, t = {:.4g}\n",
      steps / seconds, contact_steps / seconds, 1e6 * seconds / steps,
      1e6 * (now.list_seconds - then.list_seconds) / steps, (now.lists - then.lists) / steps, contact_steps / steps,
      (now.evaluations - then.evaluations) / steps, (device.time() - time) / seconds, device.time());
  Checkpoint end = start, again = start;
  device.store(end);
  fmt::print("state: hash {:016x}\n", hash(end));
  if (options.no_cpu) return end;
  device.load(start, gas.law(), false, 0, gas.surface());
  run(device, options.warm);
  run(device, options.steps);
  device.store(again);
  const bool same = again.reals == end.reals && again.integers == end.integers;
  gas.restore(end);
  const granular::GasEnergy after = gas.energy();
  fmt::print(
      "energy: kinetic {:.6g}, potential {:.6g}, dissipated {:.6g}, exchanged {:.6g}: error {:.1e} of the dissipated "
      "energy; run again, {} bits\n",
      after.kinetic, after.potential, after.dissipated, after.exchanged,
      (after.total() - before.total()) / after.dissipated, same ? "the same" : "OTHER");
  if (options.polarizability > 0)
    fmt::print("{:.2f} fields of dipoles an evaluation\n",
               static_cast<double>(end.integers["effects.coulomb.counters"].at(1)) /
                   static_cast<double>(end.integers["effects.coulomb.counters"].at(0)));
  return end;
}

/// Prints the arrays in which two states differ.
void print_differences(const Checkpoint& a, const Checkpoint& b) {
  const auto differ = [](const auto& one, const auto& other) {
    for (const auto& [name, values] : one) {
      const auto& others = other.at(name);
      std::size_t count = values.size() == others.size() ? 0 : 1, first = 0;
      double most = 0;
      for (std::size_t k = 0; k < std::min(values.size(), others.size()); ++k)
        if (values[k] != others[k])
          first = count++ == 0 ? k : first, most = std::max(most, std::abs(static_cast<double>(values[k] - others[k])));
      if (count > 0)
        fmt::print("{}: {} of {} numbers differ, by up to {:.2e}, first {}\n", name, count, values.size(), most, first);
    }
  };
  differ(a.reals, b.reals), differ(a.integers, b.integers);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Times a gas of grains on a CUDA device and compares it with the CPU's");
  app.add_option("scene", options.scene, "scene file")->required();
  app.add_option("--temperature", options.temperature, "at the start; the scene's if not given");
  app.add_option("--charge", options.charge,
                 "magnitude of the grains' charges, which have both signs (default: the scene's)");
  app.add_option("--step", options.step, "mechanics.step");
  app.add_option("--accuracy", options.accuracy, "effects.coulomb.accuracy");
  app.add_option("--polarizability", options.polarizability, "of induced dipoles; none if not given");
  app.add_option("--tolerance", options.tolerance, "of induced dipoles");
  app.add_option("--contact-steps", options.contact_steps, "mechanics.contact_substeps");
  app.add_option("--steps", options.steps, "that are timed");
  app.add_option("--warm", options.warm, "steps before");
  app.add_flag("--no-exchange", options.no_exchange, "without effects.charge_exchange");
  app.add_flag("--no-cpu", options.no_cpu, "compare nothing");
  app.add_option("--copies", options.copies, "repeats the box along each axis");
  app.add_option("--devices", options.devices, "numbers of the CUDA devices (default: the first)")->delimiter(',');
  app.add_flag("--host", options.host, "run the device's algorithms on the CPU");
  CLI11_PARSE(app, argc, argv);
  try {
    const Scene scene = prepared(options);
    granular::Gas gas(scene);
    fmt::print("{} grains, {}\n", scene.conductors.size(), options.scene);
    const Checkpoint start = gas.save();
    Checkpoint single;
    if (options.devices.size() > 1) {  // first on one of them
      const auto one = granular::device::make_cuda_gas(scene, {options.devices[0]});
      single = measure(gas, *one, options, start);
    }
    const auto device =
        options.host ? granular::device::make_host_gas(scene) : granular::device::make_cuda_gas(scene, options.devices);
    if (!options.no_cpu) compare(gas, *device);
    const Checkpoint end = measure(gas, *device, options, start);
    if (options.devices.size() > 1) print_differences(single, end);
  } catch (const std::exception& error) {
    fmt::print(stderr, "device_gas: {}\n", error.what());
    return 1;
  }
}
