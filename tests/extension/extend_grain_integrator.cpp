// An integrator of grains that is added from outside: leapfrog, with one evaluation of all forces a step.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "src/granular/contacts.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/integrator.hpp"
#include "tests/grains.hpp"

using namespace lichtenberg;

namespace {

/// Half a flight, the forces of the middle for the whole step, half a flight (Verlet 1967, position form). Of second
/// order where contacts are elastic.
class Leapfrog final : public granular::GasIntegrator {
 public:
  double longest_step(granular::Gas& gas) const override { return granular::step_that_resolves_contacts(gas, 10); }

  void step(granular::Gas& gas, double end) override {
    const double begin = gas.time(), dt = end - begin;
    const std::vector<double> from = gas.bodies().position;
    const auto near = gas.near(dt);
    const std::vector<Pair> pairs(near.begin(), near.end());
    fly(gas, begin + 0.5 * dt, 0.5 * dt);
    const granular::ContactLoad load = gas.contact_load(pairs);
    gas.kick(dt);
    std::vector<double>& momentum = gas.model_to_change().bodies.momentum;
    for (std::size_t k = 0; k < momentum.size(); ++k) momentum[k] += dt * load.force[k];
    fly(gas, end, 0.5 * dt);
    gas.note(granular::touches_between(from, gas.bodies(), gas.contacts(), pairs, begin, dt), begin,
             dt * load.dissipation);
    gas.settle_contacts();
  }

 private:
  static void fly(granular::Gas& gas, double time, double dt) {
    const Bodies& b = gas.bodies();
    std::vector<double> path;
    for (std::size_t k = 0; k < b.momentum.size(); ++k) path.push_back(dt * b.momentum[k] / b.mass[k / b.dimension]);
    gas.move(path, time);
  }
};

constexpr double end = 2;  // t0: some ten swings

/// Two opposite charges that swing in contact. They start where they touch: a contact that begins fast within a step
/// would add an error that depends on where in the step it begins.
Scene bound_pair(Integrator integrator, double step) {
  Scene scene = grains::cube(10, integrator);
  scene.mechanics.step = step;
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 0});
  scene.effects.add(effects::CoulombOptions{.strength = 5, .sum = effects::CoulombSum::minimum_image});
  grains::add_pair(scene, 0, 1e-6, 1);
  scene.conductors[0].velocity.y = 0.3, scene.conductors[1].velocity.y = -0.3;
  scene.stop.time = end;
  return scene;
}

/// Momenta at the end of a run.
std::vector<double> momenta(GranularMotion motion) {
  motion.advance_to(end, [] { return false; });
  return motion.checkpoint().reals.at("momentum");
}

double error(double step, const std::vector<double>& exact) {
  // The scene names another integrator, which must not move the grains.
  const std::vector<double> found =
      momenta(GranularMotion(bound_pair(Integrator::verlet, step), std::make_unique<Leapfrog>()));
  double most = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) most = std::max(most, std::abs(found[k] - exact[k]));
  return most;
}

}  // namespace

TEST_CASE("added integrator of grains: its error falls with the square of the step") {
  const std::vector<double> exact = momenta(GranularMotion(bound_pair(Integrator::cvode, 0.05)));
  const double coarse = error(0.004, exact), middle = error(0.002, exact), fine = error(0.001, exact);
  CHECK(coarse < 0.01);
  CHECK(coarse / middle == doctest::Approx(4).epsilon(0.1));
  CHECK(middle / fine == doctest::Approx(4).epsilon(0.1));
}
