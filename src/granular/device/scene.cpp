#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/charge_mesh.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/pace.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::granular::device {
namespace {

[[noreturn]] void refuse(const Scene& scene, const std::string& what) {
  throw InputError(fmt::format("{}: device = \"cuda\" has no {}: \"cpu\" has", scene.path, what));
}

void check_coulomb(const Scene& scene, const effects::CoulombOptions& options) {
  if (options.sum != effects::CoulombSum::mesh)
    refuse(scene, fmt::format("effects.coulomb.sum = \"{}\"", name_of(options.sum)));
  if (options.accuracy < 1e-6)
    refuse(scene, fmt::format("effects.coulomb.accuracy = {:g}, its single precision reaches 1e-6", options.accuracy));
}

void check_exchange(const Scene& scene, const effects::ChargeExchangeOptions& options) {
  if (options.model == effects::ExchangeModel::none) return;
  if (options.model != effects::ExchangeModel::impact)
    refuse(scene, fmt::format("effects.charge_exchange.model = \"{}\"", name_of(options.model)));
  if (options.each_step) refuse(scene, "effects.charge_exchange.each_step");
  if (options.capacity) refuse(scene, "effects.charge_exchange.capacity");
}

double smallest_diameter(const Scene& scene) {
  return 2 * std::ranges::min(scene.conductors, {}, &Conductor::radius).radius;
}

periodic::MeshChoice mesh_for(const Scene& scene, const effects::CoulombOptions& options) {
  const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>();
  return periodic::choose_quick_mesh({.accuracy = options.accuracy,
                                      .charges = static_cast<int>(scene.conductors.size()),
                                      .lengths = scene.domain.box().lengths,
                                      .contact = smallest_diameter(scene),
                                      .polarizability = dipoles ? std::optional(dipoles->polarizability) : std::nullopt,
                                      .on_device = true});
}

constexpr double widest_skin = 2.4;  // of lists; that a gas has had at T = 10

/// Grains nearer than that to one, if they are evenly spread.
double grains_within(const Scene& scene, double range) {
  const Vec3 lengths = scene.domain.box().lengths;
  return static_cast<double>(scene.conductors.size()) / (lengths.x * lengths.y * lengths.z) * 4.2 * range * range *
         range;
}

/// Entries of a list are counted in 32 bits.
void check_list(const Scene& scene, const effects::CoulombOptions& options) {
  const double cutoff = mesh_for(scene, options).cutoff + widest_skin;
  const double entries = static_cast<double>(scene.conductors.size()) * grains_within(scene, cutoff);
  if (entries < std::numeric_limits<int>::max()) return;
  refuse(scene,
         fmt::format(
             "room in its lists for {} grains with {:.0f} others each within {:.2g} d0, as effects.coulomb.accuracy = "
             "{:g} asks for",
             scene.conductors.size(), grains_within(scene, cutoff), cutoff, options.accuracy));
}

}  // namespace

void check_scene(const Scene& scene) {
  if (!scene.reference) refuse(scene, "scenes without [reference] but for their field");
  if (scene.dimension() != 3) refuse(scene, "grains in the plane");
  if (!scene.domain.box().periodic(0) || !scene.domain.box().periodic(1) || !scene.domain.box().periodic(2))
    refuse(scene, "walls around grains");
  if (scene.mechanics.integrator != lichtenberg::Integrator::multirate)
    refuse(scene, fmt::format("mechanics.integrator = \"{}\"", name_of(scene.mechanics.integrator)));
  if (const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>();
      dipoles && dipoles->sum != periodic::DipoleSum::ewald)
    refuse(scene, fmt::format("effects.induced_dipoles.sum = \"{}\"", name_of(dipoles->sum)));
  if (const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>(); dipoles && dipoles->degree > 1)
    refuse(scene, "effects.induced_dipoles.degree above 1");
  if (const auto* coulomb = scene.effects.find<effects::CoulombOptions>()) {
    check_coulomb(scene, *coulomb);
    check_list(scene, *coulomb);
  }
  if (const auto* exchange = scene.effects.find<effects::ChargeExchangeOptions>()) check_exchange(scene, *exchange);
}

double bytes_needed(const Scene& scene) {
  // Arrays of grains and of entries in lists (gas.hpp), a mesh of whole numbers, points, modes and factors with the
  // transforms' own, and what starts the device; lists with the widest skin.
  constexpr double a_grain = 630, an_entry = 210, a_partner = 4, a_column = 4, a_point = 28, start = 300e6;
  constexpr double a_dipole = 450;  // with its history and what solves it
  const double n = static_cast<double>(scene.conductors.size());
  double bytes = start + n * (a_grain + 0.5 * 1.25 * an_entry * grains_within(scene, 1 + widest_skin));
  if (const auto* coulomb = scene.effects.find<effects::CoulombOptions>()) {
    const periodic::MeshChoice choice = mesh_for(scene, *coulomb);
    const auto [x, y, z] = choice.mesh.points;
    if (scene.effects.has("induced_dipoles")) bytes += n * a_dipole;
    bytes += n * (25 * a_column + 1.25 * a_partner * grains_within(scene, choice.cutoff + widest_skin)) +
             a_point * x * y * z;
  }
  return bytes;
}

GasOptions gas_options(const Scene& scene) {
  const Bodies bodies = make_bodies(scene);
  GasOptions options{.lengths = bodies.box.lengths,
                     .mass = bodies.mass,
                     .radius = bodies.radius,
                     .step = scene.mechanics.step,
                     .contact_steps = scene.mechanics.contact_steps,
                     .seed = scene.seed,
                     .path = scene.path,
                     .bytes = bytes_needed(scene)};
  if (const auto* coulomb = scene.effects.find<effects::CoulombOptions>()) {
    const periodic::MeshChoice choice = mesh_for(scene, *coulomb);
    options.tables =
        periodic::device::make_tables(choice.mesh, periodic::prolate_cloud(choice.band_limit, choice.cutoff));
    options.strength = coulomb->strength;
    options.way = way_for(coulomb->accuracy, scene.conductors.size(), smallest_diameter(scene));
    options.charged = true;
  }
  if (const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>())
    options.polarizability = dipoles->polarizability, options.dipole_tolerance = dipoles->tolerance;
  if (const auto* exchange = scene.effects.find<effects::ChargeExchangeOptions>()) {
    options.exchange = {exchange->strength, exchange->exponent};
    options.charged = true;
    options.exchanges = exchange->model != effects::ExchangeModel::none;
  }
  if (const auto* drag = scene.effects.find<effects::GasDragOptions>())
    options.wind = effects::Wind{drag->stokes, drag->speed, drag->hold, scene.seed};
  if (const auto* force = scene.effects.find<effects::UniformForceOptions>())
    options.acceleration = force->acceleration.value;
  return options;
}

void check_room(const GasOptions& options, double free) {
  if (options.bytes <= free) return;
  constexpr double mebibyte = 1 << 20;
  const std::size_t grains = options.mass.size();
  throw Failure(fmt::format(
      "{}: {} grains take about {:.0f} MiB of the CUDA device, of which {:.0f} are free: {:.0f} of them would fit",
      options.path, grains, options.bytes / mebibyte, free / mebibyte,
      std::floor(static_cast<double>(grains) * (free / options.bytes))));
}

}  // namespace lichtenberg::granular::device
