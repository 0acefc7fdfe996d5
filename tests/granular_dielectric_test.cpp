// Dielectric grains of unlike permittivities, as dipoles and with multipoles.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "src/effects/read_scene.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/model/frame.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

namespace granular_dielectric_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using doctest::Approx;

namespace {

constexpr double first_charge = 0.7, second_charge = -0.4;

/// Scene of two grains of radii 0.5 and 0.3 and permittivities 5 and 40 in free space, or of their mirror image.
Scene unlike(double distance, int degree, bool mirrored = false) {
  const auto grain = [&](double x, bool first) {
    return fmt::format(
        "[[conductor]]\nposition = [{:.17g}, 10, 10]\nradius = {}\ncharge = {}\nrelative_permittivity = {}\n", x,
        first ? 0.5 : 0.3, first ? first_charge : second_charge, first ? 5 : 40);
  };
  return parse_scene("[units]\n[domain]\nsize = [20, 20, 20]\nunbounded = true\n" + grain(10, !mirrored) +
                         grain(10 + distance, mirrored) +
                         fmt::format("[effects.viscoelastic_contact]\n[effects.coulomb]\n[effects.induced_dipoles]\n"
                                     "degree = {}\ntolerance = 1e-10\n",
                                     degree),
                     "unlike.toml");
}

struct Interaction {
  double force = 0, energy = 0;
  std::vector<double> dipole{};
};

/// Returns the force on the first grain along x, the energy and the dipoles.
Interaction interaction(const Scene& scene) {
  const effects::Coulomb coulomb(scene);
  Bodies bodies = make_bodies(scene);
  bodies.charge = {scene.conductors[0].charge, scene.conductors[1].charge};
  const State state{.bodies = bodies, .neighbours = {}};
  std::vector<double> force(6);
  coulomb.add_forces(state, force);
  CHECK(std::abs(force[0] + force[3]) < 1e-8);
  Frame frame;
  coulomb.add_columns(state, frame);
  return {force[0], coulomb.stored_energy(state), frame.reals("dipole")};
}

/// Polarizability of a dielectric sphere.
double polarizability(double permittivity, double radius) {
  return (permittivity - 1) / (permittivity + 2) * radius * radius * radius;
}
const double a1 = polarizability(5, 0.5), a2 = polarizability(40, 0.3);

/// Energy of two dipoles in line (periodic_unlike_dipoles_test.cpp).
double energy_of_dipoles(double r) {
  const double e1 = -second_charge / (r * r), e2 = first_charge / (r * r), a = 2 / (r * r * r);
  return first_charge * second_charge / r -
         0.5 * (a1 * e1 * e1 + a2 * e2 * e2 + 2 * a * a1 * a2 * e1 * e2) / (1 - a1 * a2 * a * a);
}

}  // namespace

TEST_CASE("unlike dielectric grains: as dipoles they have their closed form") {
  for (const double r : {0.85, 2.0}) {
    CAPTURE(r);
    const Interaction found = interaction(unlike(r, 1));
    CHECK(found.energy == Approx(energy_of_dipoles(r)).epsilon(1e-9));
    const double step = 1e-4, slope = (energy_of_dipoles(r + step) - energy_of_dipoles(r - step)) / (2 * step);
    CHECK(found.force == Approx(slope).epsilon(1e-6));
  }
}

// The next multipoles, quadrupoles with (eps - 1) / (eps + 3/2) R^5, have the energy -A_2 q^2 / (2 r^6).
TEST_CASE("unlike dielectric grains: far multipoles are dipoles and quadrupoles") {
  const double r = 6, quadrupoles = 0.5 / std::pow(r, 6) *
                                    (second_charge * second_charge * 4 / 6.5 * std::pow(0.5, 5) +
                                     first_charge * first_charge * 39 / 41.5 * std::pow(0.3, 5));
  const Interaction found = interaction(unlike(r, 12));
  const double polarization = found.energy - first_charge * second_charge / r;
  const double dipoles = energy_of_dipoles(r) - first_charge * second_charge / r;
  CHECK(polarization == Approx(dipoles - quadrupoles).epsilon(1e-4));
  CHECK(std::abs(polarization / dipoles - 1) > 3e-3);  // quadrupoles are visible
}

TEST_CASE("unlike dielectric grains: forces are energy slopes, mirrored ones too") {
  for (const int degree : {1, 3, 8}) {
    CAPTURE(degree);
    const double r = 0.9, step = 1e-3;
    const Interaction found = interaction(unlike(r, degree));
    const auto energy = [&](double at) { return interaction(unlike(at, degree)).energy; };
    const double slope =
        (8 * (energy(r + step) - energy(r - step)) - (energy(r + 2 * step) - energy(r - 2 * step))) / (12 * step);
    CHECK(found.force == Approx(slope).epsilon(1e-6));
    const Interaction mirrored = interaction(unlike(r, degree, true));
    CHECK(mirrored.force == Approx(found.force).epsilon(1e-8));
    CHECK(mirrored.energy == Approx(found.energy).epsilon(1e-9));
    CHECK(mirrored.dipole[0] == Approx(-found.dipole[3]).epsilon(1e-8));
  }
}

TEST_CASE("relative_permittivity: grains without it have the polarizability") {
  const Scene scene = parse_scene(
      "[units]\n[domain]\nsize = [20, 20, 20]\nunbounded = true\n[[population]]\ncount = 2\nrelative_permittivity = 3\n"
      "[[population]]\ncount = 1\n[effects.viscoelastic_contact]\n[effects.coulomb]\n[effects.induced_dipoles]\n"
      "polarizability = 0.01\n",
      "grains.toml");
  const auto& options = *scene.effects.find<effects::InducedDipolesOptions>();
  CHECK(options.each == std::vector<double>{0.05, 0.05, 0.01});
  CHECK(options.polarizability == 0.05);
  CHECK(options.relative_permittivity(0, 0.5) == Approx(3));
}

TEST_CASE("relative_permittivity: a CUDA device refuses it by name") {
  Scene scene = viscoelastic(20);
  scene.effects.add(effects::CoulombOptions{});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.05, .each = {0.05, 0.01}});
  add(scene, {5, 10, 10}, {}, 1);
  add(scene, {8, 10, 10}, {}, -1);
  CHECK(message_of([&] { granular::device::make_host_gas(scene); }).find("relative_permittivity of grains") !=
        std::string::npos);
}

}  // namespace granular_dielectric_test
