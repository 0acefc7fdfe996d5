#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "src/effects/coulomb.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/restitution.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"
#include "validation/theory/driven_gas.hpp"

namespace granular_test {

using namespace lichtenberg;
using granular::ContactLoad;
using granular::Gas;
using granular::GasEnergy;
using namespace lichtenberg::grains;

TEST_CASE("contact onset that rounding puts after the step: the pair decelerates") {
  Scene scene = grains::cube(10);
  grains::add(scene, {4.5 + 1e-7, 5, 5}, {1, 0, 0});
  grains::add(scene, {5.5, 5, 5}, {-1, 0, 0});
  Bodies bodies = make_bodies(scene);
  const double time = 1;
  std::vector<GrainContact> contacts{{{0, 1}, std::nextafter(time, 2), 2}};
  const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
  motion->advance(bodies, contacts, {}, {.begin = time, .time = 0.005, .fastest = 1}, parallel::Team::single());
  CHECK(bodies.momentum[0] + bodies.momentum[3] == doctest::Approx(0));
  CHECK(bodies.momentum[0] < 1);  // Both grains have decelerated.
  CHECK(bodies.momentum[0] > 0);
}

// Queries in each step cause no list rebuild. The fastest of 200 grains has 3.5 times the thermal speed and flies 0.3
// diameters in 17 steps. Stronger contact forces can double the number of rebuilds (regression values: 9 without
// charges, 11 with them).
TEST_CASE("gas: 100 steps need fewer than 25 neighbour searches") {
  for (const bool with_charges : {false, true}) {
    Scene scene = with_charges ? charged(9, Integrator::multirate, 0.1, 1e-3) : viscoelastic(9);
    scene.mechanics.step = 0.005;
    scene.stop.time = 1e3;
    add_gas(scene, 200, 8.9, 1);
    GranularMotion motion(scene);
    int steps = 0;
    const auto ask = [&] {
      motion.exact_anywhere();
      motion.progress();
      return ++steps == 100;
    };
    try {
      motion.advance_to(10, ask);
    } catch (const Paused&) {
    }
    CHECK(steps == 100);
    CHECK(motion.searches() > 2);
    CHECK(motion.searches() < 25);
  }
}

// Collisions do not double the largest speed of equal grains, but light grains among heavy ones can exceed it. The gap
// of half a diameter closes before the next planned rebuild.
TEST_CASE("contact search: contact of a grain faster than predicted is found once") {
  Scene scene = grains::cube(10);
  grains::add(scene, {4, 5, 5}, {0.01, 0, 0});
  grains::add(scene, {5.5, 5, 5}, {0, 0, 0});
  Bodies bodies = make_bodies(scene);
  std::vector<GrainContact> contacts;
  const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
  std::size_t begun = 0;
  constexpr double dt = 0.01;
  for (int n = 0; n < 60; ++n) {
    if (n == 1) bodies.momentum[0] = 1;
    const granular::ContactSteps all{.begin = n * dt,
                                     .time = dt,
                                     .fastest = granular::grain_statistics(bodies, parallel::Team::single()).fastest,
                                     .velocity_change = n == 0 ? INFINITY : 0};
    begun += motion->advance(bodies, contacts, {}, all, parallel::Team::single()).record.begun.size();
  }
  CHECK(begun == 1);
}

namespace {

/// Bounds on restitution errors up to speeds of 1 v0 and 5 v0. They are the worst errors at dt = 0.005 in
/// docs/measurements/granular.json, increased by up to 10 % for other phases. Multirate takes 30 steps per shortest
/// contact at twice the largest speed, 0.0086 at v = 1; its bounds are above the errors at 0.01. CVODE has an error of
/// 1e-13 in each of some hundred steps.
struct RestitutionError {
  Integrator integrator;
  double at_1, at_5;
};
const RestitutionError restitution_errors[] = {{Integrator::multirate, 2.5e-5, 7e-5},
                                               {Integrator::verlet, .0011, .0020},
                                               {Integrator::gear, .0011, .0018},
                                               {Integrator::gear_printed, .0018, .0047},
                                               {Integrator::cvode, 1e-9, 1e-9}};

}  // namespace

TEST_CASE("restitution of an isolated pair: every integrator obeys the law") {
  for (const auto& [integrator, at_1, at_5] : restitution_errors)
    for (const double speed : {0.1, 1.0, 5.0}) {
      CAPTURE(name_of(integrator));
      CAPTURE(speed);
      const Scene scene = viscoelastic(10, integrator);
      const double exact = theory::collision({278.6, 27.7}, speed).restitution;
      const int phases = integrator == Integrator::cvode ? 2 : 10;
      for (int k = 0; k < phases; ++k)
        CHECK(std::abs(restitution(scene, speed, 1 + (k + 0.5) / phases) - exact) < (speed > 1 ? at_5 : at_1));
    }
}

// A frame of another run can be an initial state. Hertz's law F = k x^(3/2) stores 2/5 k x^(5/2), of which each grain
// receives half. The grains separate at v = sqrt(2 stored / m_eff) = 1.19. The error of v is at most that of a
// restitution up to 5 v0; the relative error of the energy is twice that.
TEST_CASE("grains that overlap at the start: stored energy becomes kinetic") {
  constexpr double overlap = 0.1, elastic = 278.6;
  const double stored = 0.4 * elastic * std::pow(overlap, 2.5);
  for (const auto& [integrator, at_1, at_5] : restitution_errors) {
    CAPTURE(name_of(integrator));
    Scene scene = cube(10, integrator);
    scene.effects.add(effects::ViscoelasticContactOptions{.elastic = elastic, .dissipative = 0});
    add(scene, {4, 5, 5});
    add(scene, {5 - overlap, 5, 5});
    Run run(scene);
    CHECK(run.gas.energy().contact == doctest::Approx(stored).epsilon(1e-12));
    run.to(1);
    CHECK(run.gas.contacts().empty());
    CHECK(run.gas.collisions == 0);
    CHECK(std::abs(run.gas.energy().kinetic / stored - 1) < 2 * at_5);
  }
}

// An impact takes some hundred steps. Each step's error is the tolerance, relative and absolute, as the rms of 13
// components. A component of about 1 thus has an error of 2 sqrt(13) times the tolerance at worst: 700 in all, and less
// with few long steps.
TEST_CASE("cvode integrator of grains: restitution error follows the tolerance") {
  Scene scene = viscoelastic(10, Integrator::cvode);
  const double exact = theory::collision({278.6, 27.7}, 1).restitution;
  double before = 0;
  for (const double tolerance : {1e-10, 1e-4}) {
    scene.mechanics.relative_tolerance = tolerance;
    const double error = std::abs(restitution(scene, 1, 1.25) - exact);
    CHECK(error < 700 * tolerance);
    CHECK(error > 10 * before);
    before = error;
  }
}

TEST_CASE("cvode integrator of grains: slow grains just apart collide exactly once") {
  constexpr double speed = 1e-5;
  Scene scene = viscoelastic(40, Integrator::cvode);
  add_pair(scene, speed, 3e-6);
  Run run(scene);
  for (int k = 1; k <= 10; ++k) run.to(0.37 * k);
  CHECK(run.gas.collisions == 1);
  CHECK(run.gas.contacts().empty());
  const double expected = granular::expected_collision(run.gas.law(), 0.5, 1, speed).restitution;
  const double after = norm(velocity<3>(run.gas.bodies(), 1) - velocity<3>(run.gas.bodies(), 0));
  // Positions are rounded by 4e-15; the overlap is 5e-6.
  CHECK(after / speed == doctest::Approx(expected).epsilon(1e-6));
}

// The force of a linear contact jumps at onset, and a fixed step resolves the onset to within one step. The error is of
// the order dt / t_c = 0.005 / 0.13 of the effect of this force, B v, relative to 1 - 0.9.
TEST_CASE("linear contact: every integrator gives the stated restitution") {
  for (const Integrator integrator : all_integrators)
    for (const double phase : {1.0, 1.3, 1.7}) {
      CAPTURE(name_of(integrator));
      Scene scene = cube(10, integrator);
      scene.effects.add(effects::LinearContactOptions{.restitution = 0.9});
      const bool exact = integrator == Integrator::multirate || integrator == Integrator::cvode;
      if (integrator == Integrator::gear || integrator == Integrator::gear_printed) scene.mechanics.step = 0.002;
      CHECK(std::abs(restitution(scene, 2, phase) - 0.9) < (exact ? 2e-6 : 0.1 * 0.04));
    }
}

TEST_CASE("step too long for the contacts: refused; the suggested one is accepted") {
  for (const Integrator integrator : {Integrator::verlet, Integrator::gear}) {
    Scene scene = viscoelastic(10, integrator);
    add_pair(scene, 1, 0.1);
    scene.mechanics.step = 0.03;
    Run run(scene);
    const std::string message = message_of([&] { run.to(1); });
    CHECK(message.find("mechanics.step = 0.03 is too long") != std::string::npos);
    const double suggested_step = std::stod(message.substr(message.rfind("a step of ") + 10));
    scene.mechanics.step = suggested_step;
    CHECK_NOTHROW(Run(scene).to(1));
    scene.mechanics.step = 1.12 * suggested_step;  // 0.95 of the suitable value, to two digits.
    CHECK_THROWS_AS(Run(scene).to(1), InputError);
  }
}

// With K q^2 = 0.1 the contact carries E xi^(3/2) = 0.1 at xi = 5.05e-3. The reduced mass 1/2 oscillates with stiffness
// 1.5 E sqrt(xi) = 29.7 and a period of 0.815 t0, a quarter of which is 0.204.
TEST_CASE("step too long for bound pairs: refused with the longest allowed one") {
  Scene scene = charged(10, Integrator::multirate, 0.1, 0);
  add_pair(scene, 0.01, 0.1, 1);
  scene.mechanics.step = 0.3;
  const std::string message = message_of([&] { Run(scene).to(1); });
  CHECK(message.find("mechanics.step = 0.3 is too long") != std::string::npos);
  CHECK(message.find("; at most 0.2 is allowed") != std::string::npos);
  scene.mechanics.step = 0.2;
  CHECK_NOTHROW(Run(scene).to(1));
  scene.mechanics.step = 0.21;
  CHECK_THROWS_AS(Run(scene).to(1), InputError);
}

// Grains approach each other, some with up to six simultaneous contacts. ContactMotion extrapolates the forces of other
// contacts linearly in time, so errors are of second order. Momentum is conserved to rounding, and no step raises the
// energy by more than its error.
TEST_CASE("multiple contacts: second order, energy does not grow, momentum constant") {
  Scene scene = viscoelastic(20);
  add_gas(scene, 13, 4.4, 0);
  for (Conductor& grain : scene.conductors) grain.velocity = -0.5 * (grain.position - 0.5 * scene.domain.size);
  const auto end = [&](int contact_steps) {
    scene.mechanics.contact_steps = contact_steps;
    Run run(scene);
    double before = INFINITY;
    for (int n = 1; n <= 32; ++n) {
      run.to(0.05 * n);
      const GasEnergy now = run.gas.energy();
      CHECK(now.kinetic + now.contact < before + 1e-3);
      before = now.kinetic + now.contact;
    }
    const double scale = 13 * 0.5;
    CHECK(std::abs(momentum(run.gas.bodies()) - momentum(Gas(scene).bodies())) < 1e-14 * scale * 32 * contact_steps);
    return run.gas.bodies().momentum;
  };
  const std::vector<double> reference = end(3200);
  std::vector<double> errors;
  for (const int steps : {25, 50, 100, 200}) {
    const std::vector<double> found = end(steps);
    double worst = 0;
    for (std::size_t k = 0; k < found.size(); ++k) worst = std::max(worst, std::abs(found[k] - reference[k]));
    errors.push_back(worst);
  }
  // Regression value: 1.1e-5; constant forces of other contacts over a step would give more.
  CHECK(errors[0] < 5e-5);
  CHECK(errors[3] < errors[0] / 64);  // The step is an eighth.
}

// Twelve charges of -1 surround one of 12. They fall on it and on each other, bounce and come to rest. Impulses at both
// ends of a step leave an oscillation of second order in the step; Verlet leaves none.
TEST_CASE("charged cluster: energy decreases until forces balance at rest") {
  Scene scene = viscoelastic(30, Integrator::verlet);
  scene.effects.add(effects::CoulombOptions{.strength = 0.1, .sum = effects::CoulombSum::minimum_image});
  add(scene, 0.5 * scene.domain.size, {}, 12);
  add_gas(scene, 12, 5, 0, 4);
  for (std::size_t i = 1; i < scene.conductors.size(); ++i) scene.conductors[i].charge = -1;
  Run run(scene);
  double before = INFINITY;
  const double dissipated = [&] {
    for (int n = 1; n <= 2000; ++n) {
      run.to(0.1 * n);
      const GasEnergy now = run.gas.energy();
      const double left = now.kinetic + now.contact + now.potential;
      CHECK(left < before + 1e-4);
      before = left;
    }
    return run.gas.energy().dissipated;
  }();
  CHECK(dissipated > 1);
  CHECK(run.gas.contacts().size() >= 12);
  std::vector<double> force = run.gas.smooth_forces();
  double largest = 0, left_over = 0;
  const ContactLoad contacts = run.gas.contact_load(run.gas.candidate_pairs(0.01));
  for (std::size_t k = 0; k < force.size(); ++k) {
    largest = std::max(largest, std::abs(force[k]));
    left_over = std::max(left_over, std::abs(force[k] + contacts.force[k]));
  }
  CHECK(left_over < 0.05 * largest);  // Sliding grains dissipate little.
  CHECK(momentum(run.gas.bodies()) < 1e-12);
}

TEST_CASE("elastic stage: conserves energy and ends at the given temperature") {
  for (const Integrator integrator : {Integrator::multirate, Integrator::verlet, Integrator::gear}) {
    CAPTURE(name_of(integrator));
    Scene scene = viscoelastic(5, integrator);
    scene.effects.add<effects::ChargeExchangeOptions>();
    scene.effects.add(effects::GasDragOptions{.stokes = 1});
    scene.stages = {{.duration = 1, .stiffness = 4, .temperature = 2}};
    scene.mechanics.step = integrator == Integrator::gear ? 0.0015 : 0.005;
    add_gas(scene, 60, 4.9, 1);
    Run run(scene);
    const double before = run.gas.energy().kinetic;
    run.to(0.9);
    const GasEnergy during = run.gas.energy();
    CHECK(run.gas.collisions > 100);
    CHECK(during.dissipated == 0);
    CHECK(during.driven == 0);
    // The energy errors of elastic collisions have both signs: at most 1e-4 with Multirate, 1e-3 per collision with the
    // others.
    CHECK(std::abs(during.kinetic + during.contact - before) <
          (integrator == Integrator::multirate ? 1e-3 : 2e-2) * before);
    run.to(1);
    CHECK(2 * run.gas.energy().kinetic / (3 * 60) == doctest::Approx(2).epsilon(1e-14));
    CHECK(run.gas.energy().driven != 0);
    run.to(1.5);
    CHECK(run.gas.energy().dissipated > 0);
    CHECK(run.gas.energy().driven < 0.9 * run.gas.energy().kinetic);
  }
}

TEST_CASE("gas with one grain 500 times faster than the rest: no contact is missed") {
  Scene scene = viscoelastic(8);
  add_gas(scene, 150, 7.9, 1e-4);
  scene.conductors.front().velocity = {7, 5, 3};
  Run run(scene);
  std::size_t seen = 0;
  for (int n = 0; n < 300; ++n) {
    run.step(100);
    const Bodies& b = run.gas.bodies();
    std::set<Pair> noted;
    for (const GrainContact& contact : run.gas.contacts()) noted.insert(contact.pair);
    std::set<Pair> found;
    for (int i = 0; i < b.size(); ++i)
      for (int j = i + 1; j < b.size(); ++j)
        if (norm(spheres<3>(b).box.difference(position<3>(b, i), position<3>(b, j))) < 1) found.insert({i, j});
    CHECK(noted == found);
    seen += found.size();
  }
  CHECK(seen > 100);
}

TEST_CASE("periodic box: restitution across faces, edges and corners is unchanged") {
  Scene middle = viscoelastic(10);
  const double expected = restitution(middle, 2, 1);
  for (int n = 0; n < 8; ++n)
    for (int axis = 0; axis < 3; ++axis) {
      Scene scene = viscoelastic(10);
      add_pair(scene, 2, 1e-9 + scene.mechanics.step * 2);
      const Vec3 at = {n & 1 ? 5.0 : 0, n & 2 ? 5.0 : 0, n & 4 ? 5.0 : 0};
      for (Conductor& c : scene.conductors) {
        Vec3 p{}, v{};
        for (int k = 0; k < 3; ++k) p[(k + axis) % 3] = c.position[k], v[(k + axis) % 3] = c.velocity[k];
        c.position = p + at, c.velocity = v;
        for (int k = 0; k < 3; ++k) c.position[k] -= 10 * std::floor(c.position[k] / 10);
      }
      Run run(scene);
      while (run.gas.collisions == 0 || !run.gas.contacts().empty()) run.step(run.gas.time() + 1);
      const double speed = norm(velocity<3>(run.gas.bodies(), 1) - velocity<3>(run.gas.bodies(), 0));
      // Positions are rounded by 1e-15, which enters as sqrt(overlap).
      CHECK(speed / 2 == doctest::Approx(expected).epsilon(1e-9));
    }
}

TEST_CASE("uniform force: its work equals the recorded driving energy") {
  for (const Integrator integrator : all_integrators) {
    Scene scene = viscoelastic(10, integrator);
    scene.effects.add(effects::UniformForceOptions{.acceleration = {{0, 0, -2}, 3}});
    add(scene, {5, 5, 5}, {1, 0, 0});
    Run run(scene);
    run.to(3);
    CHECK(velocity<3>(run.gas.bodies(), 0).z == doctest::Approx(-6).epsilon(1e-12));
    CHECK(run.gas.energy().driven == doctest::Approx(18).epsilon(1e-12));
    // The force acts at both ends of a step. The displacement is that of the trapezoidal rule, exact here.
    CHECK(position<3>(run.gas.bodies(), 0).z + 10 * run.gas.bodies().image[2] == doctest::Approx(5 - 9).epsilon(1e-11));
  }
}

// Free grains: each velocity component is redrawn after each correlation time, with variance speed^2 tanh(S hold / 2).
// There are 3 N components at ten instants, five correlation times apart and thus independent to exp(-5). The bound is
// four standard deviations, 4 sqrt(2 / (30 N)).
TEST_CASE("gas drag: random wind drives free grains to the theoretical temperature") {
  constexpr int n = 512;
  Scene scene = viscoelastic(80);
  scene.effects.add(effects::GasDragOptions{.stokes = 1, .speed = 0.1, .correlation_time = 1});
  scene.mechanics.step = 0.5;
  for (int i = 0; i < n; ++i) add(scene, {5 + 10.0 * (i % 8), 5 + 10.0 * (i / 8 % 8), 5 + 10.0 * (i / 64)});
  Run run(scene);
  double temperature = 0;
  for (int k = 1; k <= 10; ++k) {
    run.to(5 * k);
    temperature += 2 * run.gas.energy().kinetic / (3 * n) / 10;
  }
  const GasEnergy budget = run.gas.energy();
  CHECK(temperature == doctest::Approx(0.01 * std::tanh(0.5)).epsilon(4 * std::sqrt(2.0 / (30 * n))));
  CHECK(budget.total() == doctest::Approx(0).epsilon(1e-12 * budget.driven));
}

// The temperature has a correlation time of 1 / (2 S) = 1 and is averaged over 60 correlation times of the wind. These
// are about 60 samples of 3 N / 2 degrees of freedom; the bound is four standard deviations. The contact duration
// (omega t_c = 0.03) reduces the collision rate, which changes T by 0.5 %. Without collisions T would be 15 % higher.
TEST_CASE("gas drag: collisions lower the temperature to the theoretical value") {
  constexpr int n = 216;
  const double edge = std::cbrt(n * std::numbers::pi / 6 / 0.05);
  const theory::RandomDrag drag{.stokes = 0.5, .speed = 1.8, .hold = 1};
  const double expected = theory::driven_temperature(n / std::pow(edge, 3), {[](double) { return 1.0; }}, drag);
  Scene scene = grains::cube(edge);
  scene.effects.add(effects::LinearContactOptions{.stiffness = 3000, .restitution = 1});
  scene.effects.add(effects::GasDragOptions{.stokes = drag.stokes, .speed = drag.speed, .correlation_time = drag.hold});
  scene.mechanics.contact_steps = 16;
  add_gas(scene, n, edge, expected);
  Run run(scene);
  run.to(5);
  double temperature = 0;
  constexpr int looks = 600;
  for (int k = 1; k <= looks; ++k) {
    run.to(5 + 0.1 * k);
    temperature += 2 * run.gas.energy().kinetic / (3 * n) / looks;
  }
  const double free = theory::driven_temperature(1e-12, {[](double) { return 1.0; }}, drag);
  CHECK(free == doctest::Approx(1.8 * 1.8 * (1 - (1 - std::exp(-0.5)) / 0.5)).epsilon(1e-6));
  CHECK(free > 1.12 * expected);
  CHECK(temperature == doctest::Approx(expected).epsilon(4 * std::sqrt(2.0 / (3 * n * 60)) + 0.005));
}

// Integers and masses that are powers of two are exact in floating point. The fastest grain is the first, the last or
// another.
TEST_CASE("grain_statistics: exact kinetic energy and largest speed of the grains") {
  for (const int d : {2, 3})
    for (const int count : {1, 7, 8, 21})
      for (const int fast : {0, count / 2, count - 1}) {
        CAPTURE(d);
        CAPTURE(count);
        CAPTURE(fast);
        Bodies bodies{.dimension = d};
        double energy = 0;
        for (int i = 0; i < count; ++i) {
          bodies.radius.push_back(0.5);
          bodies.mass.push_back(i % 2 == 0 ? 2 : 4);
          for (int k = 0; k < d; ++k) bodies.momentum.push_back(i == fast && k == 1 ? 400 : i % 3 + k);
          for (int k = 0; k < d; ++k) energy += std::pow(bodies.momentum[i * d + k], 2) / (2 * bodies.mass[i]);
        }
        double square = 0;
        for (int k = 0; k < d; ++k) square += std::pow(bodies.momentum[fast * d + k] / bodies.mass[fast], 2);
        const granular::GrainStatistics found = granular::grain_statistics(bodies, parallel::Team::single());
        CHECK(found.kinetic == energy);
        CHECK(found.fastest == std::sqrt(square));
      }
}

}  // namespace granular_test
