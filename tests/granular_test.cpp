#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <set>

#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_state.hpp"
#include "src/model/frame.hpp"
#include "src/theory/restitution.hpp"
#include "tests/dielectric_pair.hpp"
#include "tests/grains.hpp"
#include "tests/message.hpp"

using namespace lichtenberg;
using granular::ContactLoad;
using granular::Gas;
using granular::GasEnergy;
using namespace lichtenberg::grains;

namespace {

constexpr std::array all = {Integrator::multirate, Integrator::verlet, Integrator::gear, Integrator::gear_printed,
                            Integrator::cvode};

Scene viscoelastic(double edge, Integrator integrator = Integrator::multirate) {
  Scene scene = cube(edge, integrator);
  scene.effects.add<effects::ViscoelasticContactOptions>();
  return scene;
}

/// Charges attract by nearest images, and contacts move charge.
Scene charged(double edge, Integrator integrator, double strength = 1, double exchange = 0.25) {
  Scene scene = viscoelastic(edge, integrator);
  scene.effects.add(effects::CoulombOptions{.strength = strength, .sum = effects::CoulombSum::minimum_image});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = exchange});
  if (integrator == Integrator::gear || integrator == Integrator::gear_printed) scene.mechanics.step = 0.0025;
  return scene;
}

/// Charges polarize each other, by the mesh.
Scene polarized(double edge, double strength = 1, double exchange = 0.25) {
  Scene scene = viscoelastic(edge);
  scene.effects.add(effects::CoulombOptions{.strength = strength, .accuracy = 1e-2});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.075, .tolerance = 1e-4});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = exchange});
  return scene;
}

struct End {
  std::vector<double> position, momentum, charge;
  GasEnergy energy;
  std::int64_t collisions = 0;
};

End end_of(Run& run) {
  const Bodies& b = run.gas.bodies();
  return {b.position, b.momentum, b.charge, run.gas.energy(), run.gas.collisions};
}

void check_same_bits(const End& a, const End& b) {
  CHECK(a.position == b.position);
  CHECK(a.momentum == b.momentum);
  CHECK(a.charge == b.charge);
  CHECK(a.energy.dissipated == b.energy.dissipated);
  CHECK(a.energy.exchanged == b.energy.exchanged);
  CHECK(a.collisions == b.collisions);
}

/// Runs to time 1 have the same bits, one from its start and one restored at 0.6 to so many threads. Returns the
/// collisions of each.
std::int64_t check_restored(Scene scene, int threads = 1) {
  Run whole(scene);
  whole.to(0.6);
  Checkpoint checkpoint = whole.gas.save();
  whole.integrator->save(checkpoint);
  whole.to(1);
  scene.mechanics.threads = threads;
  Run resumed(scene);
  resumed.gas.restore(checkpoint);
  resumed.integrator->restore(checkpoint);
  resumed.to(1);
  check_same_bits(end_of(whole), end_of(resumed));
  return whole.gas.collisions;
}

double sum(const std::vector<double>& values) {
  double all_of_them = 0;
  for (const double v : values) all_of_them += v;
  return all_of_them;
}

int grains_for(Integrator integrator) { return integrator == Integrator::cvode ? 8 : 60; }

// Pairs are waited for from one call to the next, or searched for in each, where velocities are said to have changed;
// with forces and, in between, kicks, and with more steps a call than a search lasts.
void check_waiting(const Scene& scene) {
  struct End {
    Bodies bodies;
    std::vector<GrainContact> contacts;
    double dissipated = 0;
    std::size_t begun = 0;
  };
  const auto end = [&](double kicked, int steps) {
    End now{.bodies = make_bodies(scene)};
    std::vector<double> held(now.bodies.momentum.size());
    for (std::size_t k = 0; k < held.size(); ++k) held[k] = std::sin(static_cast<double>(k));
    const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
    constexpr double dt = 0.005;
    for (int n = 0; n < 400; n += steps) {
      const granular::ContactSteps all{.begin = n * dt,
                                       .time = steps * dt,
                                       .steps = steps,
                                       .fastest = granular::fastest(now.bodies),
                                       .kicked = n == 0 ? INFINITY : kicked,
                                       .gain = 2 * steps * dt};
      const auto done = motion->advance(now.bodies, now.contacts, held, all, parallel::Team::single());
      now.dissipated += done.record.dissipated;
      now.begun += done.record.begun.size();
      for (std::size_t k = 0; k < held.size(); ++k) now.bodies.momentum[k] -= steps * dt * held[k];
      wrap(now.bodies);
    }
    return now;
  };
  for (const int steps : {1, 40}) {
    const double kick = 2 * steps * 0.005;  // the longest of the forces is sqrt(3) long at most
    const End waited = end(kick, steps), searched = end(INFINITY, steps);
    CHECK(waited.begun > 300);
    CHECK(waited.begun == searched.begun);
    CHECK(waited.bodies.position == searched.bodies.position);
    CHECK(waited.bodies.momentum == searched.bodies.momentum);
    CHECK(waited.dissipated == searched.dissipated);
    CHECK(waited.contacts.size() == searched.contacts.size());
  }
}

}  // namespace

TEST_CASE("a touch at the very end of a step, later by rounding than the next one begins") {
  Scene scene = grains::cube(10);
  grains::add(scene, {4.5 + 1e-7, 5, 5}, {1, 0, 0});
  grains::add(scene, {5.5, 5, 5}, {-1, 0, 0});
  Bodies bodies = make_bodies(scene);
  const double time = 1;
  std::vector<GrainContact> contacts{{{0, 1}, std::nextafter(time, 2), 2}};
  const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
  motion->advance(bodies, contacts, {}, {.begin = time, .time = 0.005, .fastest = 1}, parallel::Team::single());
  CHECK(bodies.momentum[0] + bodies.momentum[3] == doctest::Approx(0));
  CHECK(bodies.momentum[0] < 1);  // they have braked each other
  CHECK(bodies.momentum[0] > 0);
}

TEST_CASE("which pairs are looked at, and since when they are waited for, changes no bit of a gas") {
  Scene scene = viscoelastic(9);
  add_gas(scene, 200, 8.9, 4);
  check_waiting(scene);
}

// Where several pairs of a grain touch in one step, sums over them depend on their order.
TEST_CASE("nor does it where a crowd of grains falls together") {
  Scene scene = viscoelastic(9);
  Random random({.seed = 3, .purpose = RandomPurpose::population});
  for (int n = 0; n < 125; ++n) {
    const Vec3 from_middle = 1.03 * Vec3{n % 5 - 2.0, n / 5 % 5 - 2.0, n / 25 - 2.0};
    const Vec3 shift{random.uniform(0, 0.01), random.uniform(0, 0.01), random.uniform(0, 0.01)};
    add(scene, Vec3{4.5, 4.5, 4.5} + from_middle + shift, -2.0 * from_middle);
  }
  check_waiting(scene);
}

// What a run asks of its motion in each step makes nobody look for pairs anew. The fastest of 200 grains, 3.5 times the
// thermal speed, flies .3 diameters in 17 steps; contacts that push harder than before make searches earlier, twice as
// often at the most here (found: 9 without charges, 11 with them).
TEST_CASE("pairs are looked for when the fastest has flown its way, not in each step") {
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

// Collisions make no grain of many equal ones twice as fast as the fastest was, but light ones among heavy ones. The
// gap of half a diameter is closed before pairs would be looked for again.
TEST_CASE("a grain that became faster than was foreseen is seen from the next call on") {
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
    const granular::ContactSteps all{
        .begin = n * dt, .time = dt, .fastest = granular::fastest(bodies), .kicked = n == 0 ? INFINITY : 0};
    begun += motion->advance(bodies, contacts, {}, all, parallel::Team::single()).record.begun.size();
  }
  CHECK(begun == 1);
}

// What each integrator's errors may be: GRANULAR's table of the worst errors at dt = .005 (here a tenth more: phases
// are others), and what they fall by. Multirate takes 30 steps of the shortest contact at twice the fastest speed,
// .0086 at v = 1, where the table has 2.5e-5 for .01. CVODE: 1e-13 a step, of some hundred.
TEST_CASE("a pair alone has the restitution of its law by every integrator, whenever it touches") {
  struct Row {
    Integrator integrator;
    double at_1, at_5;
  };
  for (const auto& [integrator, at_1, at_5] :
       {Row{Integrator::multirate, 2.5e-5, 7e-5}, Row{Integrator::verlet, .0011, .0020},
        Row{Integrator::gear, .0011, .0018}, Row{Integrator::gear_printed, .0018, .0047},
        Row{Integrator::cvode, 1e-9, 1e-9}})
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

// The force of a linear contact jumps at touch, which a fixed step finds to within itself: an error of the order of
// dt / t_c = .005 / .13 of what the force does then, B v, to the restitution's 1 - .9.
TEST_CASE("a linear contact has its restitution") {
  for (const Integrator integrator : all)
    for (const double phase : {1.0, 1.3, 1.7}) {
      CAPTURE(name_of(integrator));
      Scene scene = cube(10, integrator);
      scene.effects.add(effects::LinearContactOptions{.restitution = 0.9});
      const bool exact = integrator == Integrator::multirate || integrator == Integrator::cvode;
      if (integrator == Integrator::gear || integrator == Integrator::gear_printed) scene.mechanics.step = 0.002;
      CHECK(std::abs(restitution(scene, 2, phase) - 0.9) < (exact ? 2e-6 : 0.1 * 0.04));
    }
}

TEST_CASE("a step too long for the contacts is refused, with one that would do") {
  for (const Integrator integrator : {Integrator::verlet, Integrator::gear}) {
    Scene scene = viscoelastic(10, integrator);
    add_pair(scene, 1, 0.1);
    scene.mechanics.step = 0.03;
    Run run(scene);
    const std::string message = message_of([&] { run.to(1); });
    CHECK(message.find("mechanics.step = 0.03 is too long") != std::string::npos);
    const double would_do = std::stod(message.substr(message.find("; ") + 2));
    scene.mechanics.step = would_do;
    CHECK_NOTHROW(Run(scene).to(1));
    scene.mechanics.step = 1.12 * would_do;  // .95 to two digits of what would
    CHECK_THROWS_AS(Run(scene).to(1), InputError);
  }
}

// Where K q^2 = .1 the contact bears E xi^(3/2) = .1, xi = 5.05e-3: m_eff = 1/2 swings on 1.5 E sqrt(xi) = 29.7 with a
// period of .815 t0, a quarter of which is .204.
TEST_CASE("a step in which grains that charges hold together would swing is refused, with the longest that would do") {
  Scene scene = charged(10, Integrator::multirate, 0.1, 0);
  add_pair(scene, 0.01, 0.1, 1);
  scene.mechanics.step = 0.3;
  const std::string message = message_of([&] { Run(scene).to(1); });
  CHECK(message.find("mechanics.step = 0.3 is too long") != std::string::npos);
  CHECK(message.find("; 0.2 is the longest") != std::string::npos);
  scene.mechanics.step = 0.2;
  CHECK_NOTHROW(Run(scene).to(1));
  scene.mechanics.step = 0.21;
  CHECK_THROWS_AS(Run(scene).to(1), InputError);
}

// Contacts of grains that fly to each other, some in up to six contacts at once: errors fall with the square of the
// step (ContactMotion holds what others do to a pair linear in time), momentum is kept to rounding, and no step
// raises the energy by more than it is wrong.
TEST_CASE("grains in several contacts: second order, energy falls, momentum stays") {
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
  CHECK(errors[0] < 5e-5);            // found: 1.1e-5; 2.2e-4 with what others do held over a step
  CHECK(errors[3] < errors[0] / 64);  // an eighth of the step
}

// Twelve charges of -1 around one of 12: they fall on it and each other, bounce and come to rest. Impulses of charges
// at both ends of a step leave a flutter that falls with the square of the step, Verlet none.
TEST_CASE("a cluster cools to rest: energy falls at each instant, and forces balance") {
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
  const ContactLoad contacts = run.gas.contact_load(run.gas.near(0.01));
  for (std::size_t k = 0; k < force.size(); ++k) {
    largest = std::max(largest, std::abs(force[k]));
    left_over = std::max(left_over, std::abs(force[k] + contacts.force[k]));
  }
  CHECK(left_over < 0.05 * largest);  // grains that slide on each other lose little
  CHECK(momentum(run.gas.bodies()) < 1e-12);
}

TEST_CASE("a box hardly longer than twice the cut-off of its charges is long enough") {
  Scene scene = viscoelastic(4);
  scene.effects.add(effects::CoulombOptions{.accuracy = 1e-3});
  add(scene, {1, 1, 1}, {0.3, 0, 0}, 1);
  add(scene, {3, 3, 2}, {0, 0.2, 0}, -1);
  Run run(scene);
  run.to(0.5);
  CHECK(run.gas.steps > 0);
}

TEST_CASE("any number of threads gives the same bits") {
  Scene scene = charged(9, Integrator::multirate);
  add_gas(scene, 200, 8.9, 1);
  const auto end = [&](int threads) {
    scene.mechanics.threads = threads;
    Run run(scene);
    run.to(1);
    return end_of(run);
  };
  const End one = end(1);
  CHECK(one.collisions > 100);
  check_same_bits(one, end(2));
  check_same_bits(one, end(4));
}

TEST_CASE("a gas restored from a checkpoint goes on with the same bits") {
  for (const Integrator integrator : all) {
    CAPTURE(name_of(integrator));
    Scene scene = charged(6, integrator);
    scene.effects.add(effects::GasDragOptions{.stokes = 0.1, .speed = 1, .hold = 0.13});
    scene.stages = {{.duration = 0.1, .stiffness = 4, .temperature = 1}};
    add_gas(scene, grains_for(integrator), integrator == Integrator::cvode ? 3.5 : 5.9, 1);
    CHECK(check_restored(scene) > 0);
  }
}

TEST_CASE("a polarized gas, restored or on more threads, has the same bits") {
  Scene scene = polarized(9);
  add_gas(scene, 100, 8.9, 1);
  CHECK(check_restored(scene, 2) > 20);
}

/// K Q^2 is all that counts, and both are changed by powers of two. `end`: of a run with K and Q.
std::pair<End, End> check_scaled(const auto& end) {
  std::pair<End, End> ends{end(1, 0.25), end(4, 0.125)};
  CHECK(ends.first.position == ends.second.position);
  CHECK(ends.first.momentum == ends.second.momentum);
  CHECK(ends.first.energy.potential != 0);
  return ends;
}

TEST_CASE("(K, Q) and (4 K, Q / 2) have the same trajectory, bit for bit") {
  for (const Integrator integrator : all) {
    CAPTURE(name_of(integrator));
    const auto end = [&](double strength, double exchange) {
      Scene scene = charged(6, integrator, strength, exchange);
      add_gas(scene, grains_for(integrator), integrator == Integrator::cvode ? 3.5 : 5.9, 1);
      Run run(scene);
      run.to(1);
      return end_of(run);
    };
    const auto [one, other] = check_scaled(end);
    for (std::size_t i = 0; i < one.charge.size(); ++i) CHECK(one.charge[i] == 2 * other.charge[i]);
  }
}

TEST_CASE("dipoles are as charges: (K, Q) and (4 K, Q / 2) have the same trajectory, bit for bit") {
  const auto end = [](double strength, double exchange) {
    Scene scene = polarized(9, strength, exchange);
    add_gas(scene, 100, 8.9, 1);
    Run run(scene);
    run.to(1);
    return end_of(run);
  };
  const auto [one, other] = check_scaled(end);
  CHECK(one.energy.potential == other.energy.potential);
}

TEST_CASE("the sum of charges is 0, as a number, after any number of exchanges") {
  for (const auto model :
       {effects::ExchangeModel::impact, effects::ExchangeModel::random_walk, effects::ExchangeModel::contact_area}) {
    Scene scene = viscoelastic(5);
    scene.effects.add(effects::ChargeExchangeOptions{.model = model});
    scene.effects.add(effects::GasDragOptions{.stokes = 1, .speed = 5, .hold = 0.1});  // keeps them colliding
    add_gas(scene, 60, 4.9, 1);
    Run run(scene);
    run.to(20);
    CHECK(run.gas.collisions > 2000);
    CHECK(std::ranges::max(run.gas.bodies().charge) > 0);
    CHECK(sum(run.gas.bodies().charge) == 0);
  }
}

TEST_CASE("an elastic stage keeps energy and charges, and ends at its temperature") {
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
    // Errors of elastic restitutions: Multirate's 1e-4 and less, the others' 1e-3 a collision, in both directions.
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

TEST_CASE("no contact is missed beside a grain a thousand times as fast as the others") {
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

TEST_CASE("two grains that meet across faces, edges and corners bounce as in the middle") {
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
      CHECK(speed / 2 == doctest::Approx(expected).epsilon(1e-9));  // places round by 1e-15, in sqrt(overlap)
    }
}

TEST_CASE("the same force on all does work that is booked, and nothing else") {
  for (const Integrator integrator : all) {
    Scene scene = viscoelastic(10, integrator);
    scene.effects.add(effects::UniformForceOptions{.acceleration = {{0, 0, -2}, 3}});
    add(scene, {5, 5, 5}, {1, 0, 0});
    Run run(scene);
    run.to(3);
    CHECK(velocity<3>(run.gas.bodies(), 0).z == doctest::Approx(-6).epsilon(1e-12));
    CHECK(run.gas.energy().driven == doctest::Approx(18).epsilon(1e-12));
    // Within a step it acts at both ends: the way is that of the trapezoidal rule, exact.
    CHECK(position<3>(run.gas.bodies(), 0).z + 10 * run.gas.bodies().image[2] == doctest::Approx(5 - 9).epsilon(1e-11));
  }
}

namespace {

/// A hundred charges whose forces are right to rounding, followed for .4: where they are then, if forces are held as an
/// accuracy says, or for so long.
std::vector<double> places_of_charges(double accuracy, double step = INFINITY) {
  Scene scene = viscoelastic(9);
  scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald, .accuracy = accuracy});
  add_gas(scene, 100, 8.9, 1, 5);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.mechanics.step = step;
  scene.mechanics.contact_steps = 400;
  Run run(scene);
  run.to(0.4);
  const Bodies& b = run.gas.bodies();
  std::vector<double> places = b.position;
  for (std::size_t k = 0; k < places.size(); ++k) places[k] += b.image[k] * b.box.lengths[0];
  return places;
}

}  // namespace

// An error e of the forces, rms over rms, leads a grain e F t^2 / 2 astray if it lasts; F^2 = 4 pi n at K = q = 1 and n
// = .14, so 1.3^2. Held forces are of second order in the step, and the step goes with the root of the accuracy: so
// their error goes with it.
TEST_CASE("forces of charges are held as long as costs what their own error does") {
  const std::vector<double> exact = places_of_charges(1e-9, 5e-4);
  const auto error = [&](double accuracy) {
    const std::vector<double> places = places_of_charges(accuracy);
    double squares = 0;
    for (std::size_t k = 0; k < places.size(); ++k) squares += (places[k] - exact[k]) * (places[k] - exact[k]);
    return std::sqrt(squares / 100);
  };
  const double coarse = error(1e-3), fine = error(1e-4);
  const double by_forces = 1e-3 * 1.3 * 0.4 * 0.4 / 2;
  CHECK(coarse < 3 * by_forces);
  CHECK(coarse > by_forces / 3);
  CHECK(coarse / fine == doctest::Approx(10).epsilon(0.5));
}

TEST_CASE("charges at rest that fall towards each other are not held as if they never moved") {
  for (const double radius : {0.5, 0.25}) {
    Scene scene = viscoelastic(10);
    scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald, .accuracy = 1e-6});
    add_pair(scene, 0, 0.5, 1);
    for (Conductor& grain : scene.conductors) grain.radius = radius;
    scene.mechanics.step = INFINITY;
    Run run(scene);
    const double way = 2 * radius * 1e-3 * granular::fastest_of(2);
    const double acceleration = std::abs(run.gas.smooth_forces()[0]) / run.gas.bodies().mass[0];
    CHECK(run.integrator->longest_step(run.gas) == doctest::Approx(std::sqrt(2 * way / acceleration)).epsilon(1e-9));
  }
}

// Free grains: each component is drawn anew after each hold, of variance speed^2 tanh(S hold / 2). 3 N components at
// ten instants, five holds apart, so that they are independent to exp(-5): four standard deviations, 4 sqrt(2 / (30
// N)).
TEST_CASE("a gas that blows at random drives grains to its temperature") {
  constexpr int n = 512;
  Scene scene = viscoelastic(80);
  scene.effects.add(effects::GasDragOptions{.stokes = 1, .speed = 0.1, .hold = 1});
  scene.mechanics.step = 0.5;
  for (int i = 0; i < n; ++i) add(scene, {5 + 10.0 * (i % 8), 5 + 10.0 * (i / 8 % 8), 5 + 10.0 * (i / 64)});
  Run run(scene);
  double temperature = 0;
  for (int k = 1; k <= 10; ++k) {
    run.to(5 * k);
    temperature += 2 * run.gas.energy().kinetic / (3 * n) / 10;
  }
  const GasEnergy book = run.gas.energy();
  CHECK(temperature == doctest::Approx(0.01 * std::tanh(0.5)).epsilon(4 * std::sqrt(2.0 / (30 * n))));
  CHECK(book.total() == doctest::Approx(0).epsilon(1e-12 * book.driven));
}

// ---- beyond dipoles

namespace {

/// Two grains of charges 1 and -1, d0 / 2 in radius, in the middle of a large box; multipoles to the degree.
Scene two_dielectric_grains(double distance, int degree) {
  Scene scene = viscoelastic(60);
  scene.conductors = {{.position = {30 - distance / 2, 30, 30}, .radius = 0.5, .charge = 1},
                      {.position = {30 + distance / 2, 30, 30}, .radius = 0.5, .charge = -1}};
  scene.effects.add(effects::CoulombOptions{.sum = effects::CoulombSum::ewald});
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.075, .tolerance = 1e-6, .degree = degree});
  return scene;
}

struct Felt {
  double force = 0, energy = 0, dipole = 0;
};

Felt felt(const Scene& scene) {
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

}  // namespace

TEST_CASE("multipoles above dipoles: grains in contact attract each other as dielectric spheres do") {
  const double k = 5.5;  // (1 + 16 A) / (1 - 8 A) of A = .075
  const effects::InducedDipolesOptions options{.polarizability = 0.075};
  CHECK(options.relative_permittivity(0.5) == doctest::Approx(k).epsilon(1e-14));
  for (const double gap : {0.4, 0.02, 0.002}) {  // radii; the pair's force for 4 pi eps = 1 and a radius of 1/2
    const double exact = dielectric_pair(k, gap).attraction * 4 * std::numbers::pi / 0.25;
    const Felt found = felt(two_dielectric_grains(1 + gap / 2, 40));
    CHECK(found.force == doctest::Approx(exact).epsilon(1e-3));  // images: (dipole / 60^3) of 1
    if (gap < 0.01) CHECK(felt(two_dielectric_grains(1 + gap / 2, 1)).force < 0.9 * exact);  // dipoles alone miss much
    const double step = 1e-3, slope = (felt(two_dielectric_grains(1 + gap / 2 + step, 40)).energy -
                                       felt(two_dielectric_grains(1 + gap / 2 - step, 40)).energy) /
                                      (2 * step);
    if (gap > 0.1) CHECK(found.force == doctest::Approx(slope).epsilon(1e-4));
  }
  // Far apart dipoles are enough: what is left falls with the seventh power of the distance.
  const Felt far = felt(two_dielectric_grains(6, 8)), dipoles = felt(two_dielectric_grains(6, 1));
  CHECK(far.force == doctest::Approx(dipoles.force).epsilon(1e-4));
  CHECK(far.energy == doctest::Approx(dipoles.energy).epsilon(1e-4));
  CHECK(far.dipole == doctest::Approx(dipoles.dipole).epsilon(1e-3));
}

TEST_CASE("explain says of dielectric grains that multipoles take the place of the sum of charges") {
  Scene scene = two_dielectric_grains(1.6, 6);
  scene.effects.add(effects::CoulombOptions{});  // a mesh
  const auto remarks = effects::CoulombOptions::kind().explain(scene);
  REQUIRE(remarks.size() == 1);
  CHECK(remarks[0].text.find("relative permittivity 5.5, multipoles to degree 6, to 1e-06") != std::string::npos);
}

TEST_CASE("a gas of dielectric grains goes on from a checkpoint with the same bits") {
  Scene scene = two_dielectric_grains(1.6, 6);
  scene.effects.add(effects::CoulombOptions{.strength = 0.1, .sum = effects::CoulombSum::ewald});
  check_restored(scene);
}

TEST_CASE(
    "a gas of dielectric grains stops at checkpoints of its frames alone, since one elsewhere would change its end") {
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
