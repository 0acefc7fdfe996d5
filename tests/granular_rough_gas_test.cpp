// Tests of gases of rough grains: cooling, energy budget, conserved quantities, bitwise identity.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "src/granular/granular_motion.hpp"
#include "tests/rough_grains.hpp"

namespace granular_rough_gas_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using doctest::Approx;

namespace {

/// Rough viscoelastic gas with walls along z and adhesion.
Scene rough_gas(int count, double edge) {
  Scene scene = viscoelastic(edge);
  scene.effects.add(effects::FrictionOptions{.coefficient = 0.4, .rolling_coefficient = 0.02});
  scene.effects.add(effects::AdhesionOptions{.surface_energy = 1e-3});
  add_walls(scene, {2}, {.friction = 0.2});
  add_gas(scene, count, edge - 1.2, 1);
  Random random({.seed = 7, .purpose = RandomPurpose::population});
  for (Conductor& grain : scene.conductors)
    for (int k = 0; k < 3; ++k) grain.angular_velocity[k] = 3 * random.normal();
  return scene;
}

/// Change of the total energy of a gas up to t = 1, over the dissipated energy.
double energy_error(Scene scene, int contact_steps) {
  scene.mechanics.contact_steps = contact_steps;
  Run run(scene);
  const double before = run.gas.energy().total();
  run.to(1);
  const granular::GasEnergy energy = run.gas.energy();
  CHECK(energy.dissipated > 1);
  return std::abs(energy.total() - before) / energy.dissipated;
}

struct End {
  std::vector<double> position, momentum, angular_velocity;
  double dissipated = 0;
  std::int64_t collisions = 0;

  explicit End(Run& run)
      : position(run.gas.bodies().position),
        momentum(run.gas.bodies().momentum),
        angular_velocity(run.gas.bodies().angular_velocity),
        dissipated(run.gas.energy().dissipated),
        collisions(run.gas.collisions) {}
  bool operator==(const End&) const = default;
};

}  // namespace

TEST_CASE("rough gas: the energy error is of second order in the substep") {
  const Scene scene = rough_gas(60, 8);
  const double coarse = energy_error(scene, 24), fine = energy_error(scene, 96);
  MESSAGE("energy errors " << coarse << ", " << fine);
  CHECK(coarse < 1e-2);
  CHECK(fine < coarse / 6);  // 16 without random signs of single contacts
}

TEST_CASE("rough gas in open space: angular momentum with spins is constant") {
  Scene scene = viscoelastic(40);
  scene.effects.add(effects::FrictionOptions{.coefficient = 0.6, .rolling_coefficient = 0.1});
  add_gas(scene, 40, 5, 1, 3);
  Run run(scene);
  const Momenta before = momenta(run.gas.bodies());
  run.to(3);
  const Momenta after = momenta(run.gas.bodies());
  CHECK(run.gas.collisions > 10);
  CHECK(norm(after.linear - before.linear) < 1e-12);
  CHECK(norm(after.angular - before.angular) < 1e-10);
}

// Luding, Huthmann, McNamara and Zippelius 1998 (equations for d = 3) for hard spheres with constant e and beta:
//   dT/dt = G (-A T^(3/2) + B T^(1/2) T_r),  dT_r/dt = G (B T^(3/2) - C T^(1/2) T_r),
// with A = (1 - e^2)/4 + eta (1 - eta), B = eta^2/q, C = eta/q (1 - eta/q), eta = q (1 + beta) / (2 q + 2). The
// asymptotic ratio K = T_r/T obeys B K^2 + (C - A) K - B = 0. It is that of Gaussian velocities.
TEST_CASE("cooling of rough spheres: temperatures have the ratio of the theory") {
  constexpr double e = 0.9, beta = 0, q = 0.4;
  constexpr int count = 1000;
  Scene scene =
      frictional(18, {.stiffness = 1e5, .restitution = e}, {.coefficient = 1e3, .tangential_restitution = beta});
  scene.mechanics.contact_steps = 16;
  add_gas(scene, count, 17, 1);
  Run run(scene);
  double rotational = 0, translational = 0;
  for (double t = 0; run.gas.collisions < 18 * count; t += 1) {
    run.to(t);
    if (run.gas.collisions < 12.5 * count) continue;  // the ratio relaxes by e^-4 in 25 collisions of a grain
    const granular::GasEnergy energy = run.gas.energy();
    rotational += *energy.rotational / energy.kinetic, translational += 1;
  }
  const double eta = q * (1 + beta) / (2 * q + 2), a = (1 - e * e) / 4 + eta * (1 - eta), b = eta * eta / q,
               c = eta / q * (1 - eta / q);
  const double expected = ((a - c) + std::sqrt((c - a) * (c - a) + 4 * b * b)) / (2 * b);
  MESSAGE("ratio " << rotational / translational << ", theory " << expected << ", collisions " << run.gas.collisions);
  // Deviations: 3.7 % rms at one instant by 3000 degrees of freedom each.
  CHECK(rotational / translational == Approx(expected).epsilon(0.1));
}

TEST_CASE("rough gas: resume, threads and neighbour lists change no bit") {
  Scene scene = rough_gas(60, 8);
  scene.effects.add(effects::CoulombOptions{.strength = 0.3, .sum = effects::CoulombSum::minimum_image});
  for (DomainSide& side : scene.domain.sides) side.periodic = true;
  scene.effects.remove<effects::FlatWallsOptions>();
  charge_alternately(scene, 0.5);
  for (const bool walls : {false, true}) {
    if (walls) scene = rough_gas(60, 8);
    scene.mechanics.threads = 1;
    Run whole(scene);
    whole.to(0.6);
    Checkpoint checkpoint = whole.gas.save();
    whole.integrator->save(checkpoint);
    whole.to(1);
    scene.mechanics.threads = 3;
    Run resumed(scene);
    resumed.restore(checkpoint);
    resumed.to(1);
    CHECK(whole.gas.collisions > 15);
    CHECK(End(whole) == End(resumed));
  }
}

TEST_CASE("rough grains: frames have angular velocities, smooth ones do not") {
  Scene scene = rough_gas(10, 8);
  GranularMotion motion(scene);
  CHECK(motion.frame().reals("angular_velocity").size() == 30);
  Scene smooth = viscoelastic(8);
  add_gas(smooth, 10, 7, 1);
  CHECK(GranularMotion(smooth).frame().reals("angular_velocity").empty());
}

}  // namespace granular_rough_gas_test
