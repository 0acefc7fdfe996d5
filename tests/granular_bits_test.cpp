// Tests of bitwise identity of a gas: pair searches, threads, checkpoints, and K and Q at constant K Q^2.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "src/effects/gas_drag.hpp"
#include "src/granular/contact_event_queue.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/pair_state.hpp"
#include "tests/grains.hpp"

namespace granular_bits_test {

using namespace lichtenberg;
using granular::GasEnergy;
using namespace lichtenberg::grains;

namespace {

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

/// Checks that a run to time 1 is bitwise identical to one restored at 0.6 with the given threads. Returns the
/// collisions of the run.
std::int64_t check_restored(Scene scene, int threads = 1) {
  Run whole(scene);
  whole.to(0.6);
  Checkpoint checkpoint = whole.gas.save();
  whole.integrator->save(checkpoint);
  whole.to(1);
  scene.mechanics.threads = threads;
  Run resumed(scene);
  resumed.restore(checkpoint);
  resumed.to(1);
  check_same_bits(end_of(whole), end_of(resumed));
  return whole.gas.collisions;
}

int grains_for(Integrator integrator) { return integrator == Integrator::cvode ? 8 : 60; }

// Compares candidate pairs kept between calls with a search in each call, which a reported velocity change forces.
// Forces and kicks act between calls, and a call has more steps than a search lasts.
void check_waiting(const Scene& scene) {
  struct FinalState {
    Bodies bodies;
    std::vector<GrainContact> contacts;
    double dissipated = 0;
    std::size_t begun = 0;
  };
  const auto end = [&](double velocity_change, int steps) {
    FinalState now{.bodies = make_bodies(scene)};
    std::vector<double> held(now.bodies.momentum.size());
    for (std::size_t k = 0; k < held.size(); ++k) held[k] = std::sin(static_cast<double>(k));
    const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
    constexpr double dt = 0.005;
    for (int n = 0; n < 400; n += steps) {
      const granular::ContactSteps all{
          .begin = n * dt,
          .time = steps * dt,
          .steps = steps,
          .fastest = granular::grain_statistics(now.bodies, parallel::Team::single()).fastest,
          .velocity_change = n == 0 ? INFINITY : velocity_change,
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
    const double kick = 2 * steps * 0.005;  // The longest force vector is at most sqrt(3).
    const FinalState waited = end(kick, steps), searched = end(INFINITY, steps);
    CHECK(waited.begun > 300);
    CHECK(waited.begun == searched.begun);
    CHECK(waited.bodies.position == searched.bodies.position);
    CHECK(waited.bodies.momentum == searched.bodies.momentum);
    CHECK(waited.dissipated == searched.dissipated);
    CHECK(waited.contacts.size() == searched.contacts.size());
  }
}

/// Compares runs with equal K Q^2; K and Q change by powers of two. `end` returns the end of a run with K and Q.
std::pair<End, End> check_scaled(const auto& end) {
  std::pair<End, End> ends{end(1, 0.25), end(4, 0.125)};
  CHECK(ends.first.position == ends.second.position);
  CHECK(ends.first.momentum == ends.second.momentum);
  CHECK(ends.first.energy.potential != 0);
  return ends;
}

}  // namespace

TEST_CASE("candidate pairs kept between calls: no bit of a gas changes") {
  Scene scene = viscoelastic(9);
  add_gas(scene, 200, 8.9, 4);
  check_waiting(scene);
}

// If several pairs of a grain touch in one step, their sum depends on their order.
TEST_CASE("candidate pairs kept between calls: no bit of a dense cluster changes") {
  Scene scene = viscoelastic(9);
  Random random({.seed = 3, .purpose = RandomPurpose::population});
  for (int n = 0; n < 125; ++n) {
    const Vec3 from_middle = 1.03 * Vec3{n % 5 - 2.0, n / 5 % 5 - 2.0, n / 25 - 2.0};
    const Vec3 shift{random.uniform(0, 0.01), random.uniform(0, 0.01), random.uniform(0, 0.01)};
    add(scene, Vec3{4.5, 4.5, 4.5} + from_middle + shift, -2.0 * from_middle);
  }
  check_waiting(scene);
}

TEST_CASE("charged gas: any number of threads gives identical bits") {
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

TEST_CASE("gas, every integrator: a restored run has identical bits") {
  for (const Integrator integrator : all_integrators) {
    CAPTURE(name_of(integrator));
    Scene scene = charged(6, integrator);
    scene.effects.add(effects::GasDragOptions{.stokes = 0.1, .speed = 1, .correlation_time = 0.13});
    scene.stages = {{.duration = 0.1, .stiffness = 4, .temperature = 1}};
    add_gas(scene, grains_for(integrator), integrator == Integrator::cvode ? 3.5 : 5.9, 1);
    CHECK(check_restored(scene) > 0);
  }
}

TEST_CASE("polarized gas: a run restored with two threads has identical bits") {
  Scene scene = polarized(9);
  add_gas(scene, 100, 8.9, 1);
  CHECK(check_restored(scene, 2) > 20);
}

TEST_CASE("charged gas: Coulomb prefactor 4 K and charges Q / 2 change no bit") {
  for (const Integrator integrator : all_integrators) {
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

TEST_CASE("polarized gas: Coulomb prefactor 4 K and charges Q / 2 change no bit") {
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

TEST_CASE("dielectric grains: a run restored from a checkpoint has identical bits") {
  Scene scene = two_dielectric_grains(1.6, 6);
  scene.effects.add(effects::CoulombOptions{.strength = 0.1, .sum = effects::CoulombSum::ewald});
  check_restored(scene);
}

// A distant fast grain causes a search soon, but two accelerations of 200 close the gap of 0.2 earlier, after sqrt(2 x
// 0.2 / 400). The bound on contact forces alone would close it after that search.
TEST_CASE("contact search: a pair at rest under constant forces is found in time") {
  Scene scene = grains::cube(20);
  grains::add(scene, {5, 5, 5});
  grains::add(scene, {6.2, 5, 5});
  grains::add(scene, {12, 12, 12}, {5, 0, 0});
  Bodies bodies = make_bodies(scene);
  std::vector<GrainContact> contacts;
  const std::vector<double> held{200, 0, 0, -200, 0, 0, 0, 0, 0};
  const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
  const granular::ContactSteps all{.time = 0.05, .steps = 10, .fastest = 5, .gain = 10};
  const auto done = motion->advance(bodies, contacts, held, all, parallel::Team::single());
  REQUIRE(done.record.begun.size() == 1);
  CHECK(done.record.begun[0].since == doctest::Approx(std::sqrt(0.001)));
}

// Two grains at rest, each hit from behind by three heavy ones, meet within the call. They meet earlier than 10 % of
// the maximum contact acceleration, estimated before contacts act, predicts. The step with the larger acceleration is
// repeated with a new search.
TEST_CASE("contact search: a pair driven together faster than predicted is found") {
  Scene scene = grains::cube(20);
  const double behind = 1.01 * 0.766, aside = 1.01 * 0.643;  // 40 degrees.
  for (const int side : {-1, 1}) {
    add(scene, {10 + 0.59 * side, 10, 10});
    for (int k = 0; k < 3; ++k) {
      const double angle = 2 * std::numbers::pi / 3 * k;
      add(scene, {10 + (0.59 + behind) * side, 10 + aside * std::cos(angle), 10 + aside * std::sin(angle)},
          {-5.0 * side, 0, 0});
    }
  }
  const auto touch = [&](double velocity_change, int steps) {
    Bodies bodies = make_bodies(scene);
    for (const int heavy : {1, 2, 3, 5, 6, 7}) bodies.mass[heavy] *= 100, bodies.momentum[3 * heavy] *= 100;
    std::vector<GrainContact> contacts;
    const auto motion = granular::make_contact_motion(ViscoelasticLaw{278.6, 27.7}, 3);
    constexpr double dt = 0.005;
    for (int n = 0; n < 20; n += steps) {
      const granular::ContactSteps all{.begin = n * dt,
                                       .time = steps * dt,
                                       .steps = steps,
                                       .fastest = 5,
                                       .velocity_change = n == 0 ? INFINITY : velocity_change,
                                       .search_path = 1};
      const auto done = motion->advance(bodies, contacts, {}, all, parallel::Team::single());
      for (const GrainContact& one : done.record.begun)
        if (one.pair == Pair{0, 4}) return one.since;
    }
    return -1.0;
  };
  const double since = touch(INFINITY, 1);
  CHECK(since > 0.03);
  CHECK(touch(0, 1) == since);
  CHECK(touch(0, 20) == since);
}

TEST_CASE("ContactEventQueue: valid for steps up to 25 % longer than searched for") {
  Scene scene = grains::cube(20);
  add(scene, {10, 10, 10});
  add(scene, {12, 10, 10});
  granular::ContactEventQueue<3> queue;
  queue.search(
      make_bodies(scene), {.fastest = 1}, 1, 0.004, [](Pair) { return false; }, parallel::Team::single());
  CHECK(queue.is_valid_for(0.004, 1));
  CHECK(queue.is_valid_for(0.005, 1));
  CHECK_FALSE(queue.is_valid_for(0.006, 1));
}

}  // namespace granular_bits_test
