// Tests of a screened Coulomb force between charged grains, added from outside (yukawa.hpp): energy and forces.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "src/effects/effects.hpp"
#include "tests/extension/yukawa.hpp"

namespace extend_pair_force {

using namespace lichtenberg;

namespace {

double total(granular::Gas& gas) {
  const granular::GasEnergy energy = gas.energy();
  return energy.kinetic + energy.contact + energy.potential;
}

/// Largest change of the energy of two like charges that repel each other before contact.
double energy_error(double step) {
  Scene scene = grains::cube(20, Integrator::verlet);
  scene.mechanics.step = step;
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 0});
  scene.effects.add(YukawaOptions{{.strength = 20}});
  grains::add_pair(scene, 0.5, 2.5);
  for (Conductor& grain : scene.conductors) grain.charge = 1;
  grains::Run run(scene);
  const double before = total(run.gas);
  double most = 0;
  for (; run.gas.time() < 15; run.step(15)) most = std::max(most, std::abs(total(run.gas) - before));
  CHECK(run.gas.bodies().momentum[0] < 0);  // The grain has reversed.
  CHECK(run.gas.collisions == 0);
  return most / before;
}

}  // namespace

TEST_CASE("user-defined pair force: energy error is of second order in the step") {
  const double coarse = energy_error(0.01), fine = energy_error(0.005);
  CHECK(coarse < 1e-3);
  CHECK(coarse / fine == doctest::Approx(4).epsilon(0.05));
}

TEST_CASE("user-defined pair force: force and Jacobian equal central differences") {
  Model model = effects::make_model(yukawa_gas());
  const int n = static_cast<int>(model.bodies.position.size());
  std::vector<double> force(n), above(n), below(n);
  ForceJacobian jacobian(3);
  model.forces(0, force);
  model.jacobian(0, jacobian);
  constexpr double h = 1e-5;  // Errors of h^2 over the cube of the screening length 0.5, and of rounding, 1e-16 over h.
  for (int k = 0; k < n; k += 7) {
    double& x = model.bodies.position[k];
    const double at = x;
    x = at + h;
    const double up = model.stored_energy(0);
    model.forces(0, above);
    x = at - h;
    const double down = model.stored_energy(0);
    model.forces(0, below);
    x = at;
    CHECK(force[k] == doctest::Approx((down - up) / (2 * h)).epsilon(1e-6).scale(1));
    double derivative = 0;
    for (const ForceJacobian::Entry& entry : jacobian.by_position)
      if (entry.row == k && entry.column == k) derivative += entry.value;
    CHECK(derivative == doctest::Approx((above[k] - below[k]) / (2 * h)).epsilon(1e-6).scale(1));
  }
}

}  // namespace extend_pair_force
