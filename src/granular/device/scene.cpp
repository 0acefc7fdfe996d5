#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "src/effects/device_forces.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/flat_walls.hpp"
#include "src/granular/device/bounds.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/slow_force_limits.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::granular::device {
namespace {

using effects::DeviceForces;
using effects::refuse_on_device;

/// Returns the forces, drives and charge exchange of all effects for a device. Throws InputError for an effect that a
/// device does not compute, for unsupported options, and for laws without CUDA kernels if `target` is cuda.
DeviceForces device_forces(const Scene& scene, Target target) {
  DeviceForces forces;
  const auto with_kernels = [](const auto& forms) {
    return std::ranges::all_of(forms, [](const auto& form) { return form.make_on_cuda != nullptr; });
  };
  Effects ordered = scene.effects;  // the order of the CPU
  ordered.sort(effects::all_kinds());
  for (const Effects::Entry& entry : ordered) {
    if (!entry.kind->device) refuse_on_device(scene, "effects." + entry.kind->name);
    entry.kind->device(scene, forces);
    if (target == Target::cuda && !(with_kernels(forces.parts) && with_kernels(forces.drives)))
      refuse_on_device(scene, "a law without kernels in effects." + entry.kind->name);
  }
  return forces;
}

/// Throws InputError for scenes that several devices do not compute, and for those that would not gain by it.
void check_for_several(const Scene& scene, const DeviceForces& forces, Target target) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(scene.path + ": several CUDA devices do not compute " + what +
                     ": one device is needed, as in --device cuda:0");
  };
  if (!surface_key(scene).empty()) refuse("rough grains (" + surface_key(scene) + ")");
  for (int k = 0; k < 3; ++k)
    if (!scene.domain.box().periodic(k)) refuse("domains that are not periodic along all axes");
  if (forces.polarizability > 0) refuse("induced dipoles (effects.induced_dipoles)");
  if (forces.exchanges && forces.exchange.in_order())
    refuse("charge exchange that depends on earlier exchanges (effects.charge_exchange)");
  if (!forces.parts.empty()) refuse("pair laws and forces of fields");
  if (!forces.drives.empty()) refuse("external drives");
  constexpr std::size_t fewest = 300'000;
  if (target == Target::cuda && scene.conductors.size() < fewest)
    refuse(
        fmt::format("{} grains faster than one does (they gain from {} grains on)", scene.conductors.size(), fewest));
}

double bytes_needed(const Scene& scene, const DeviceForces& forces) {
  // Arrays of grains, entries of lists with the widest skin (gas.hpp), and the CUDA context.
  constexpr double start = 300e6;
  const bool rough = !surface_key(scene).empty();
  double a_grain = 630, an_entry = 210;
  if (rough) a_grain += 280, an_entry += 85;
  if (scene.effects.has<effects::FlatWallsOptions>())
    for (int side = 0; side < 6; ++side)
      if (!scene.domain.sides[side].periodic) a_grain += 190;
  const double entries = 0.5 * 1.25 * effects::grains_within(scene, 1 + effects::widest_skin);
  return start + static_cast<double>(scene.conductors.size()) * (a_grain + an_entry * entries) + forces.bytes;
}

}  // namespace

void check_scene(const Scene& scene, Target target, int devices) {
  if (!scene.reference) refuse_on_device(scene, "scenes without [units], except for their field");
  if (scene.dimension() != 3) refuse_on_device(scene, "grains in the plane");
  const bool walls = scene.effects.has<effects::FlatWallsOptions>();
  for (int k = 0; k < 3; ++k)
    if (!scene.domain.box().periodic(k) && !scene.domain.open && !walls)
      refuse_on_device(scene, "grains in a domain that is not periodic along all axes, without effects.flat_walls");
  if (!scene.mechanics.integrator->is_on_device)
    refuse_on_device(scene, fmt::format("mechanics.integrator = \"{}\"", name_of(scene.mechanics.integrator)));
  const DeviceForces forces = device_forces(scene, target);
  if (devices > 1) check_for_several(scene, forces, target);
}

std::vector<int> chosen_devices(const Scene& scene) {
  if (scene.cuda_devices != std::vector{-1}) return scene.cuda_devices.empty() ? std::vector{0} : scene.cuda_devices;
  std::vector<int> all(cuda_device_count());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

double expected_gain(std::size_t grains, int devices) {
  // Shares of a step on one device: transforms, which each device repeats, and for each exchange of halos a layer
  // of grains whose number grows with N^(2/3). A constant time is lost to communication.
  const double n = static_cast<double>(grains), one = 1.55e-9 * n, repeated = 0.2 * one, p = devices;
  const double halo = 7e-9 * std::pow(n, 2.0 / 3);
  return one / ((one - repeated) / p + repeated + halo + 1.55e-4);
}

double bytes_needed(const Scene& scene) { return bytes_needed(scene, device_forces(scene, Target::host)); }

GasOptions gas_options(const Scene& scene) {
  const Bodies bodies = make_bodies(scene);
  GasOptions options{device_forces(scene, Target::host)};
  options.lengths = bodies.box.lengths, options.sides = bodies.box.sides;
  options.rough = !surface_key(scene).empty();
  options.mass = bodies.mass, options.radius = bodies.radius;
  const bool by_list = std::isinf(scene.mechanics.step) && only_contacts_act(scene);  // lists of a device are longer
  options.step = by_list ? scene.mechanics.integrator->usual_step : scene.mechanics.step;
  options.contact_steps = scene.mechanics.contact_steps;
  options.seed = scene.seed, options.path = scene.path;
  options.bytes = bytes_needed(scene, options);
  if (const auto& mesh = options.mesh)
    options.tables = periodic::device::make_tables(mesh->mesh, periodic::prolate_cloud(mesh->band_limit, mesh->cutoff),
                                                   options.enclosure);
  options.max_path = std::isinf(options.step) ? path_by_accuracy(scene) : path_by_length(scene);
  options.attraction = contact_attraction(scene);
  return options;
}

periodic::device::MeshTables cloud_tables(const GasOptions& options, Vec3 extents) {
  constexpr double more = ChargeBounds::growth;
  const periodic::MeshChoice choice =
      periodic::choose_cloud_mesh(extents + Vec3{more, more, more}, options.request, options.enclosure);
  return periodic::device::make_tables(choice.mesh, choice.cloud(), options.enclosure);
}

void check_memory(const GasOptions& options, double free) {
  if (options.bytes <= free) return;
  constexpr double mebibyte = 1 << 20;
  const std::size_t grains = options.mass.size();
  throw Failure(fmt::format(
      "{}: {} grains take about {:.0f} MiB of the CUDA device, of which {:.0f} are free: {:.0f} of them would fit",
      options.path, grains, options.bytes / mebibyte, free / mebibyte,
      std::floor(static_cast<double>(grains) * (free / options.bytes))));
}

}  // namespace lichtenberg::granular::device
