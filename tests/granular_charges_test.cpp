// Tests of grain charges: the outer step of their forces, charge conservation in collisions, and higher multipoles.
#include <doctest/doctest.h>

#include <cmath>

#include "src/effects/gas_drag.hpp"
#include "src/effects/multipole_truncation.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/pace.hpp"
#include "src/model/frame.hpp"
#include "tests/dielectric_pair.hpp"
#include "tests/grains.hpp"
#include "tests/periodic_sources.hpp"

namespace granular_charges_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;

namespace {

double sum(const std::vector<double>& values) {
  double all_of_them = 0;
  for (const double v : values) all_of_them += v;
  return all_of_them;
}

/// Positions of 100 charges with exact forces at time 0.4, for an outer step from the accuracy or of the given length.
std::vector<double> final_positions(double accuracy, double step = INFINITY) {
  Scene scene = viscoelastic(9);
  scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald, .accuracy = accuracy});
  add_gas(scene, 100, 8.9, 1, 5);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.mechanics.step = step;
  scene.mechanics.contact_steps = 400;
  Run run(scene);
  run.to(0.4);
  const Bodies& b = run.gas.bodies();
  std::vector<double> positions = b.position;
  for (std::size_t k = 0; k < positions.size(); ++k) positions[k] += b.image[k] * b.box.lengths[0];
  return positions;
}

struct PairInteraction {
  double force = 0, energy = 0, dipole = 0;
};

PairInteraction pair_interaction(const Scene& scene) {
  const effects::Coulomb coulomb(scene);
  Bodies bodies = make_bodies(scene);
  bodies.charge = {1, -1};
  const State state{.bodies = bodies, .neighbours = {}};
  std::vector<double> force(6);
  coulomb.add_forces(state, force);
  CHECK(std::abs(force[0] + force[3]) < 1e-5);
  Frame frame;
  coulomb.add_columns(state, frame);
  return {force[0], coulomb.stored_energy(state), frame.reals("dipole")[0]};
}

/// Eight grains near the sites of a lattice in a periodic cube. Grains 0, 3 and 6 have the charge `third`, others 0.6.
Scene eight_grains(double third) {
  Scene scene = cube(4);
  scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald, .accuracy = 1e-12});
  for (int i = 0; i < 8; ++i)
    add(scene, {1 + 2 * (i % 2) + 0.3 * std::sin(i), 1 + 2 * (i / 2 % 2) + 0.3 * std::sin(2 * i), 1.0 + 1.6 * (i / 4)},
        {}, i % 3 == 0 ? third : 0.6);
  return scene;
}

}  // namespace

TEST_CASE("gas in a box slightly longer than twice the Coulomb cutoff: runs") {
  Scene scene = viscoelastic(4);
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-3});
  add(scene, {1, 1, 1}, {0.3, 0, 0}, 1);
  add(scene, {3, 3, 2}, {0, 0.2, 0}, -1);
  Run run(scene);
  run.to(0.5);
  CHECK(run.gas.steps > 0);
}

TEST_CASE("charge exchange: the sum of all charges stays exactly zero") {
  for (const auto model : {effects::ExchangeModel::impact, effects::ExchangeModel::random_walk,
                           effects::ExchangeModel::contact_area, effects::ExchangeModel::polarization}) {
    Scene scene = viscoelastic(5);
    scene.effects.add(effects::ChargeExchangeOptions{.model = model, .field = Coordinates{{0, 0, 1}, 3}});
    scene.effects.add(
        effects::GasDragOptions{.stokes = 1, .speed = 5, .correlation_time = 0.1});  // The wind maintains collisions.
    add_gas(scene, 60, 4.9, 1);
    Run run(scene);
    run.to(20);
    CHECK(run.gas.collisions > 2000);
    CHECK(std::ranges::max(run.gas.bodies().charge) > 0);
    CHECK(sum(run.gas.bodies().charge) == 0);
  }
}

// A lasting rms error e of the forces displaces a grain by e F t^2 / 2. F^2 = 4 pi n = 1.3^2 at K = q = 1 and n = 0.14.
// The error of constant forces is of second order in the outer step, which is proportional to the root of the accuracy.
// It is therefore proportional to the accuracy.
TEST_CASE("outer step: displacement error within 3 times that of the force accuracy") {
  const std::vector<double> exact = final_positions(1e-9, 5e-4);
  const auto error = [&](double accuracy) {
    const std::vector<double> positions = final_positions(accuracy);
    double squares = 0;
    for (std::size_t k = 0; k < positions.size(); ++k) squares += (positions[k] - exact[k]) * (positions[k] - exact[k]);
    return std::sqrt(squares / 100);
  };
  const double coarse = error(1e-3), fine = error(1e-4);
  const double by_forces = 1e-3 * 1.3 * 0.4 * 0.4 / 2;
  CHECK(coarse < 3 * by_forces);
  CHECK(coarse > by_forces / 3);
  CHECK(coarse / fine == doctest::Approx(10).epsilon(0.5));
}

TEST_CASE("outer step: limited by the attraction of two charges at rest") {
  for (const double radius : {0.5, 0.25}) {
    Scene scene = viscoelastic(10);
    scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald, .accuracy = 1e-6});
    add_pair(scene, 0, 0.5, 1);
    for (Conductor& grain : scene.conductors) grain.radius = radius;
    scene.mechanics.step = INFINITY;
    Run run(scene);
    const double path = 2 * radius * 1e-3 * granular::fastest_of(2);
    const double acceleration = std::abs(run.gas.smooth_forces()[0]) / run.gas.bodies().mass[0];
    CHECK(run.longest_step() == doctest::Approx(std::sqrt(2 * path / acceleration)).epsilon(1e-9));
  }
}

TEST_CASE("grain multipoles: touching grains attract as dielectric spheres do") {
  const double k = 5.5;  // (1 + 16 A) / (1 - 8 A) for A = 0.075
  const effects::InducedDipolesOptions options{.polarizability = 0.075};
  CHECK(options.relative_permittivity(0, 0.5) == doctest::Approx(k).epsilon(1e-14));
  for (const double gap : {0.4, 0.02, 0.002}) {  // In radii; the pair's force for 4 pi eps = 1 and a radius of 1/2.
    const double exact = dielectric_pair(k, gap).attraction * 4 * std::numbers::pi / 0.25;
    const PairInteraction found = pair_interaction(two_dielectric_grains(1 + gap / 2, 40));
    CHECK(found.force == doctest::Approx(exact).epsilon(1e-3));  // The images contribute (dipole / 60^3) of 1.
    // Dipoles alone underestimate the force.
    if (gap < 0.01) CHECK(pair_interaction(two_dielectric_grains(1 + gap / 2, 1)).force < 0.9 * exact);
    const double step = 1e-3, slope = (pair_interaction(two_dielectric_grains(1 + gap / 2 + step, 40)).energy -
                                       pair_interaction(two_dielectric_grains(1 + gap / 2 - step, 40)).energy) /
                                      (2 * step);
    if (gap > 0.1) CHECK(found.force == doctest::Approx(slope).epsilon(1e-4));
  }
  // At large distances dipoles suffice: the remainder decreases with the seventh power of the distance.
  const PairInteraction far = pair_interaction(two_dielectric_grains(6, 8)),
                        dipoles = pair_interaction(two_dielectric_grains(6, 1));
  CHECK(far.force == doctest::Approx(dipoles.force).epsilon(1e-4));
  CHECK(far.energy == doctest::Approx(dipoles.energy).epsilon(1e-4));
  CHECK(far.dipole == doctest::Approx(dipoles.dipole).epsilon(1e-3));
}

TEST_CASE("explain: states multipole degree and error of dielectric grains") {
  Scene scene = two_dielectric_grains(1.6, 6);
  scene.effects.add(effects::CoulombOptions{});  // A mesh.
  const auto remarks = effects::CoulombOptions::kind().explain(scene);
  REQUIRE(remarks.size() == 2);
  CHECK(remarks[0].text.find("relative permittivity 5.5, multipoles to degree 6, to 1e-06") != std::string::npos);
  CHECK(remarks[1].text.find("effects.induced_dipoles.degree = 6 leaves forces at the start off by ") == 0);
}

TEST_CASE("multipole_truncation: equals the difference from bispherical forces") {
  for (const int degree : {1, 2, 4, 8}) {
    CAPTURE(degree);
    Scene scene = two_dielectric_grains(1.5, degree);
    const auto truncation = effects::multipole_truncation(scene);
    REQUIRE(truncation);
    const auto off = [&](double gap) {  // In radii; the images contribute (dipole / 60^3) of 1.
      const double exact = dielectric_pair(5.5, gap).attraction * 4 * std::numbers::pi / 0.25;
      return std::abs(pair_interaction(two_dielectric_grains(1 + gap / 2, degree)).force / exact - 1);
    };
    // A gap of 1e-4 R changes the force of touching grains by less than 1e-3.
    CHECK(truncation->in_contact == doctest::Approx(off(1e-4)).epsilon(0.02).scale(0.05));
    CHECK(truncation->at_start.has_value() == (degree > 1));
    if (degree > 1) CHECK(*truncation->at_start == doctest::Approx(off(1)).epsilon(0.02).scale(0.01));
  }
}

TEST_CASE("grain multipoles: forces are negative energy derivatives, degrees 1 to 6") {
  Scene scene = eight_grains(-1);
  for (int degree = 1; degree <= 6; ++degree) {
    CAPTURE(degree);
    scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.09, .tolerance = 1e-12, .degree = degree});
    const effects::Coulomb coulomb(scene);
    Bodies bodies = make_bodies(scene);
    bodies.charge = initial_charges(scene);
    const State state{.bodies = bodies, .neighbours = {}};
    std::vector<double> force(bodies.position.size());
    coulomb.add_forces(state, force);
    const double largest = std::abs(std::ranges::max(force, {}, [](double f) { return std::abs(f); }));
    // The error of a central difference, h^2 / 6 over the square of the gap of 0.3, is 2e-6 of the force at h = 1e-3.
    // The fourth-order difference with steps h and 2 h removes it.
    for (const int k : {0, 4, 23}) {
      const auto energy = [&] { return coulomb.stored_energy(state); };
      CHECK(std::abs(force[k] + periodic::energy_slope(bodies.position[k], 1e-3, energy)) < 1e-7 * largest);
    }
  }
}

// Point dipoles are spheres of degree 1. The uniform background that neutralizes a net charge acts on both.
TEST_CASE("grain multipoles, net charge: forces are slopes, degree 1 equals dipoles") {
  Scene scene = eight_grains(0.2);
  Bodies bodies = make_bodies(scene);
  bodies.charge = initial_charges(scene);
  const State state{.bodies = bodies, .neighbours = {}};
  effects::InducedDipolesOptions options{.polarizability = 0.09, .tolerance = 1e-12, .degree = 1};
  scene.effects.add(options);
  std::vector<double> force(bodies.position.size());
  const effects::Coulomb dipoles(scene);
  dipoles.add_forces(state, force);
  const auto size = [](double f) { return std::abs(f); };
  const double largest = size(std::ranges::max(force, {}, size));
  const laplace::SphereSolution spheres =
      laplace::SphereSolver({.accuracy = 1e-12, .degree = 1}).solve(effects::dielectric_spheres(options, bodies));
  for (int i = 0; i < bodies.size(); ++i)
    for (int k = 0; k < 3; ++k) CHECK(std::abs(spheres.sphere_force[i][k] - force[3 * i + k]) < 1e-7 * largest);
  scene.effects.find<effects::InducedDipolesOptions>()->degree = 3;
  const effects::Coulomb coulomb(scene);
  force.assign(force.size(), 0);
  coulomb.add_forces(state, force);
  for (const int k : {0, 4, 23}) {
    const auto energy = [&] { return coulomb.stored_energy(state); };
    CHECK(std::abs(force[k] + periodic::energy_slope(bodies.position[k], 1e-3, energy)) < 1e-7 * largest);
  }
}

// The odd part (q_1 - q_2) / 2 of two charges attracts, the even part (q_1 + q_2) / 2 repels. No force contains both,
// because the odd field is normal to the middle plane and the even one parallel. Like charges attract beyond a ratio
// that exact series in bispherical coordinates give. Approximate criteria are within 1 % of it (Duan and Gan 2025).
TEST_CASE("grain multipoles: like charges attract beyond the exact charge ratio") {
  for (const double polarizability : {0.09, 0.12}) {
    const double gap = 0.1;  // in radii
    const effects::InducedDipolesOptions options{.polarizability = polarizability, .tolerance = 1e-6, .degree = 40};
    const double k = options.relative_permittivity(0, 0.5);
    const double part = std::sqrt(like_charge_repulsion(k, gap) / dielectric_pair(k, gap).attraction);
    const auto repulsion = [&](double odd) {
      Scene scene = viscoelastic(10);
      for (DomainSide& side : scene.domain.sides) side.periodic = false;
      scene.domain.open = true;
      scene.effects.add(effects::CoulombOptions{});
      scene.effects.add(options);
      add(scene, {5, 5, 5}, {}, 1 + odd);
      add(scene, {5 + 1 + gap / 2, 5, 5}, {}, 1 - odd);
      return granular::Gas(scene).smooth_forces()[3];
    };
    REQUIRE(part < 1);  // the charges have equal signs
    CHECK(repulsion(0.99 * part) > 0);
    CHECK(repulsion(1.01 * part) < 0);
  }
}

TEST_CASE("pause between frames: throws for dielectric grains, stops for dipoles") {
  Scene scene = two_dielectric_grains(1.6, 6);
  scene.mechanics.integrator = Integrator::multirate;
  scene.stop.time = scene.output.every = 1;
  const auto now = [] { return true; };
  GranularMotion dielectric(scene);
  CHECK_FALSE(dielectric.exact_anywhere());
  CHECK_THROWS_AS(dielectric.advance_to(1, now), Paused);
  scene.effects.find<effects::InducedDipolesOptions>()->degree = 1;
  GranularMotion dipoles(scene);
  CHECK(dipoles.exact_anywhere());
  dipoles.advance_to(1, now);
  CHECK(dipoles.time() < 1);
}

}  // namespace granular_charges_test
