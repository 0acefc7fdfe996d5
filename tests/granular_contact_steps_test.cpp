// Tests of the number of steps per contact for a given accuracy, for an isolated contact and for a gas.
#include <doctest/doctest.h>

#include "src/effects/linear_contact.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/scene/contact_steps.hpp"
#include "tests/gas_text.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

namespace granular_contact_steps_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;

namespace {

/// Scene with the contact law of this file; without `dissipative` it is elastic.
Scene contact_scene(double edge, double dissipative, int contact_steps) {
  Scene scene = cube(edge);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = dissipative});
  scene.mechanics.contact_steps = contact_steps;
  return scene;
}

/// Largest change of the energy of two isolated elastic grains over the phases of a step at onset.
double elastic_error(int contact_steps) {
  constexpr double speed = 1;
  Scene scene = contact_scene(10, 0, contact_steps);
  scene.mechanics.step = ViscoelasticLaw{278.6, 0}.shortest_contact(speed) / contact_steps;
  double worst = 0;
  constexpr int phases = 12;
  for (int k = 0; k < phases; ++k)
    worst = std::max(worst, std::abs(std::pow(restitution(scene, speed, 1 + (k + 0.5) / phases), 2) - 1));
  return worst;
}

/// Largest errors of a head-on collision at the given speed over the phases of a step at onset.
struct ContactErrors {
  /// Error of the restitution, and of the energy balance relative to the initial kinetic energy.
  double restitution = 0, energy = 0;
};

ContactErrors contact_errors(Scene scene, double speed) {
  ContactErrors worst;
  constexpr int phases = 8;
  for (int k = 0; k < phases; ++k) {
    Scene two = scene;
    add_pair(two, speed, 0.1 * (1 + static_cast<double>(k) / phases));
    Run run(two);
    const double start = run.gas.kinetic_energy();
    while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 1);
    const double expected = granular::expected_collision(run.gas.law(), 0.5, 1, speed).restitution;
    const double found = std::sqrt(run.gas.kinetic_energy() / start);
    worst.restitution = std::max(worst.restitution, std::abs(found - expected));
    worst.energy = std::max(worst.energy, std::abs(run.gas.energy().total() / start - 1));
  }
  return worst;
}

/// Gas in which a grain is in contact for more than half of the time (phi = 0.25, T = 1).
struct DenseGas {
  std::vector<double> momentum;  ///< Momenta at time 0.3.
  /// Residual of the energy balance at time 5, relative to the dissipated or, if elastic, the kinetic energy.
  double left_over = 0;
};

DenseGas dense_gas(double dissipative, int contact_steps) {
  constexpr int grains = 120;
  const double edge = std::cbrt(grains * std::numbers::pi / 6 / 0.25);
  Scene scene = contact_scene(edge, dissipative, contact_steps);
  add_gas(scene, grains, edge, 1);
  Run run(scene);
  const granular::GasEnergy start = run.gas.energy();
  run.to(0.3);
  DenseGas found{.momentum = run.gas.bodies().momentum};
  run.to(5);
  const granular::GasEnergy end = run.gas.energy();
  found.left_over = std::abs(end.total() - start.total()) / (dissipative > 0 ? end.dissipated : start.kinetic);
  return found;
}

/// RMS difference relative to the rms momentum, of variance 1.
double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double squares = 0;
  for (std::size_t k = 0; k < a.size(); ++k) squares += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

constexpr std::array accuracies = {1e-3, 1e-4};

}  // namespace

TEST_CASE("contact_steps_for: smallest number of steps that meets the accuracy") {
  for (const double accuracy : {1e-3, 3e-4, 1e-4, 1e-5, 1e-6}) {
    const int steps = contact_steps_for(accuracy);
    CHECK(contact_error(steps) <= accuracy);
    CHECK(contact_error(steps - 1) > accuracy);
  }
  CHECK(contact_steps_for(1e-3) == 16);
  CHECK(contact_steps_for(0.1) == 16);
  CHECK(contact_steps_for(1e-15) == contact_steps_for(1e-6));
}

TEST_CASE("elastic contact: energy error meets the accuracy, not at half the steps") {
  for (const double accuracy : accuracies) {
    CHECK(elastic_error(contact_steps_for(accuracy)) < accuracy);
    CHECK(elastic_error(contact_steps_for(accuracy) / 2) > accuracy);
  }
}

TEST_CASE("dense elastic gas: energy meets the accuracy, not at half the steps") {
  for (const double accuracy : accuracies) {
    CHECK(dense_gas(0, contact_steps_for(accuracy)).left_over < accuracy);
    CHECK(dense_gas(0, contact_steps_for(accuracy) / 2).left_over > accuracy);
  }
}

// The momenta are compared before the motion is chaotic (a grain has met two others), the energy until 90 % is
// dissipated. Half the steps have four times the error by the law; the test requires a factor of two.
TEST_CASE("dense cooling gas: errors of momenta and energy meet the accuracy") {
  const DenseGas reference = dense_gas(27.7, 400);
  for (const double accuracy : accuracies) {
    const int steps = contact_steps_for(accuracy);
    const DenseGas found = dense_gas(27.7, steps), coarse = dense_gas(27.7, steps / 2);
    CHECK(rms_difference(found.momentum, reference.momentum) < accuracy);
    CHECK(found.left_over < accuracy);
    CHECK(rms_difference(coarse.momentum, reference.momentum) > 2 * rms_difference(found.momentum, reference.momentum));
    CHECK(coarse.left_over > 2 * found.left_over);
  }
}

TEST_CASE("contact_steps_for: the usual accuracy of 1e-3 holds for any damping") {
  for (const double restitution : {0.9, 0.5, 0.2, 0.1, 0.02, 1e-3}) {
    CAPTURE(restitution);
    Scene scene = cube(20);
    scene.effects.add(effects::LinearContactOptions{.stiffness = 1000, .restitution = restitution});
    scene.mechanics.contact_steps = contact_steps_for(usual_contact_accuracy);
    const ContactErrors found = contact_errors(scene, 2);
    CHECK(found.energy < usual_contact_accuracy);
    CHECK(found.restitution < usual_contact_accuracy);
  }
  for (const double dissipative : {27.7, 100.0, 1000.0})
    for (const double speed : {0.1, 2.0}) {
      CAPTURE(dissipative);
      CAPTURE(speed);
      const ContactErrors found =
          contact_errors(contact_scene(20, dissipative, contact_steps_for(usual_contact_accuracy)), speed);
      CHECK(found.energy < usual_contact_accuracy);
      CHECK(found.restitution < usual_contact_accuracy);
    }
}

TEST_CASE("contact steps: small grains keep the accuracy despite short contacts") {
  for (const bool linear : {true, false}) {
    CAPTURE(linear);
    Scene scene = contact_scene(20, 27.7, contact_steps_for(usual_contact_accuracy));
    if (linear) {
      scene = cube(20);
      scene.effects.add(effects::LinearContactOptions{.stiffness = 1000, .restitution = 0.9});
      scene.mechanics.contact_steps = contact_steps_for(usual_contact_accuracy);
    }
    scene.conductors = {{.position = {9.8, 10, 10}, .velocity = {1, 0, 0}, .radius = 0.1},
                        {.position = {10.2, 10, 10}, .velocity = {-1, 0, 0}, .radius = 0.1}};
    Run run(scene);
    const double start = run.gas.kinetic_energy();
    run.to(2);
    REQUIRE(run.gas.collisions == 1);
    CHECK(std::abs(run.gas.energy().total() / start - 1) < usual_contact_accuracy);
    CHECK(run.gas.restitution.all().worst < usual_contact_accuracy);
  }
}

TEST_CASE("time_to_resolve: usual damping does not shorten the contact time") {
  for (const std::size_t grains : {200u, 8516u, 50016u}) {
    const granular::GrainProperties properties{.typical = granular::typical_impact(grains)};
    const double fastest = 2 * granular::fastest_of(grains);
    for (const double temperature : {10.0, 1.0, 1e-3}) {
      const ViscoelasticLaw law{278.6, 27.7};
      const double impact = fastest * std::sqrt(temperature);
      CHECK(granular::time_to_resolve(law, impact, properties) == law.shortest_contact(impact));
    }
  }
}

TEST_CASE("step too long for the dashpot: refused; the suggested one is accurate") {
  for (const Integrator integrator : {Integrator::verlet, Integrator::gear}) {
    CAPTURE(name_of(integrator));
    Scene scene = cube(20, integrator);
    scene.mechanics.step = integrator == Integrator::verlet ? 0.005 : 0.0015;
    scene.effects.add(effects::LinearContactOptions{.stiffness = 1000, .restitution = 0.02});
    add_pair(scene, 2, 0.5);
    Run run(scene);
    const std::string message = message_of([&] { run.longest_step(); });
    CHECK_MESSAGE(message.find("1.5 times the damping time of a typical contact") != std::string::npos, message);
    const std::string before = "a step of ";
    scene.mechanics.step = std::stod(message.substr(message.rfind(before) + before.size()));
    scene.conductors.clear();
    CHECK(contact_errors(scene, 2).restitution < 0.02);
  }
}

TEST_CASE("contact_substeps: follow effects.coulomb.accuracy unless given") {
  const auto steps = [](const std::string& coulomb, const std::string& more = "") {
    std::string text = gas_text(2, 10, 1, 1, more);
    const std::string sum = "[effects.coulomb]\nsum = \"minimum-image\"\n";
    return parse_scene(text.replace(text.find(sum), sum.size(), coulomb), "gas.toml").mechanics.contact_steps;
  };
  const std::string to_1e_5 = "[effects.coulomb]\naccuracy = 1e-5\n";
  CHECK(steps(to_1e_5) == contact_steps_for(1e-5));
  CHECK(steps("[effects.coulomb]\naccuracy = 1e-4\n") == 50);
  CHECK(steps(to_1e_5, "[mechanics]\ncontact_substeps = 20\n") == 20);
  CHECK(steps("") == contact_steps_for(usual_contact_accuracy));
}

TEST_CASE("mechanics.step: open by default only where smooth contacts act alone") {
  const auto step = [](const std::string& more) {
    std::string text = gas_text(2, 10, 1, 1, more);
    const std::string slow = "[effects.charge_exchange]\n[effects.coulomb]\nsum = \"minimum-image\"\n";
    text.erase(text.find(slow), slow.size());
    return parse_scene(text, "gas.toml").mechanics.step;
  };
  CHECK(std::isinf(step("")));
  CHECK(step("[mechanics]\nstep = 0.01\n") == 0.01);
  CHECK(step("[effects.gas_drag]\n") == 0.05);
  CHECK(step("[effects.friction]\n") == 0.05);
}

TEST_CASE("multirate: steps of contacts alone last as long as a list of pairs") {
  Scene scene = contact_scene(8, 27.7, 45);
  add_gas(scene, 60, 8, 1);
  const auto steps_to_2 = [&](double step) {
    scene.mechanics.step = step;
    Run run(scene);
    const double fastest = run.gas.fastest();
    run.to(2);
    CHECK(run.gas.collisions > 20);
    return std::pair(run.gas.steps, 2 * fastest / granular::path_per_search);
  };
  const auto [steps, most] = steps_to_2(INFINITY);
  CHECK(static_cast<double>(steps) < most + 1);  // The gas cools.
  CHECK(steps_to_2(0.01).first == 200);
}

// Errors of contacts are those of their substeps, 1e-6 with 90 of them.
TEST_CASE("multirate: long steps change no collision, also from rest") {
  const auto end = [](Scene scene, double step) {
    scene.mechanics.step = step;
    Run run(scene);
    run.to(8);
    CHECK(run.gas.contacts().empty());
    return run.gas.bodies().momentum;
  };
  Scene flying = contact_scene(20, 27.7, 90), at_rest = flying;
  add_pair(flying, 2, 0.5);
  for (const double x : {5.0, 5.7, 6.9}) add(at_rest, {x, 10, 10});
  for (const Scene& scene : {flying, at_rest}) {
    const std::vector<double> expected = end(scene, 0.01), found = end(scene, INFINITY);
    for (std::size_t k = 0; k < found.size(); ++k) CHECK(std::abs(found[k] - expected[k]) < 1e-5);
  }
  CHECK(std::abs(end(at_rest, INFINITY)[6]) > 0.1);
}

}  // namespace granular_contact_steps_test
