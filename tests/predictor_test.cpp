// Tests of forces predicted on a coarser grid between field solves (docs/numerics/coupling.md).
#include <doctest/doctest.h>

#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/leakage.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/spheres.hpp"

namespace predictor_test {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;

namespace {

/// Dense scene in a box so small that a radius is ten cells of the field and 2.5 cells of the predictor.
Scene resolved_spheres() {
  Scene scene = random_spheres();
  scene.domain.size = {0.02, 0.02};
  for (Conductor& conductor : scene.conductors) conductor.position = conductor.position - Vec3{0.04, 0.04, 0};
  scene.electrodes = {ball("ground", {0.01, 0.01}, 0)};
  scene.field().cells = 256;
  return scene;
}

}  // namespace

TEST_CASE("predictor grid: number of cells halved while a radius keeps two cells") {
  Scene scene = resolved_spheres();
  CHECK(effects::predictor_cells(scene) == 64);
  scene.field().cells = 512;
  CHECK(effects::predictor_cells(scene) == 64);
  scene.field().cells = 128;  // Half as many cells do not justify a second field.
  CHECK(effects::predictor_cells(scene) == 0);
  scene.field().cells = 250;  // 125 cells, which cannot be halved.
  CHECK(effects::predictor_cells(scene) == 0);
  for (const auto& change : std::initializer_list<void (*)(Scene&)>{
           [](Scene& s) { s.mechanics.predictor = false; },
           [](Scene& s) { s.mechanics.coupling = FieldCoupling::monolithic; },
           [](Scene& s) { s.mechanics.integrator = Integrator::euler; },
           [](Scene& s) { s.field().method = &relaxation_method(); },
           [](Scene& s) { s.effects.add(effects::LeakageOptions{.conductivity = 1e-10}); }}) {
    Scene other = resolved_spheres();
    change(other);
    CHECK(effects::predictor_cells(other) == 0);
  }
}

TEST_CASE("coarse-grid predictor: under half the field solves, same error bound") {
  const double until = 0.3;  // Some contacts occur by then; later they amplify small errors.
  const auto run = [&](bool predictor, double tolerance) {
    Scene scene = resolved_spheres();
    scene.mechanics.predictor = predictor;
    scene.mechanics.position_tolerance *= tolerance;
    Simulation simulation(scene);
    simulation.advance_to(until);
    return std::pair{simulation.now(), simulation.counters()};
  };
  const auto [exact, many] = run(false, 0.02);
  const auto [without, plain] = run(false, 1);
  const auto [with, few] = run(true, 1);
  CHECK(few.predictions > 0);
  CHECK(few.corrections + few.rejected_corrections + 1 == few.field_solves);  // The first instant is one solve.
  CHECK(2 * few.field_solves < plain.field_solves);
  CHECK(plain.predictions == 0);
  CHECK(few.contacts_made == many.contacts_made);
  // The tolerance holds per step, and there are some tens of steps: the bound has a factor of 10, as without the
  // predictor.
  CHECK(largest_distance(without, exact) < 10e-3 * radius);
  CHECK(largest_distance(with, exact) < 10e-3 * radius);
}

TEST_CASE("coarse-grid predictor: error below one tolerance for each correction") {
  const auto run = [&](bool predictor, double tolerance) {
    Scene scene = resolved_spheres();
    scene.effects.remove<effects::ContactDischargeOptions>();  // Without contacts the forces do not jump.
    scene.mechanics.predictor = predictor;
    scene.mechanics.position_tolerance *= tolerance;
    Simulation simulation(scene);
    simulation.advance_to(0.1);
    return std::pair{simulation.now(), simulation.counters()};
  };
  const auto [exact, many] = run(false, 0.02);
  const auto [with, few] = run(true, 1);
  // Predictions aim at an error of 0.75 tolerances of 1e-3 radius. Errors of up to four are rare. The corrected error
  // grows by an unknown power of time. If it exists from the start or arises at the end, the correction misses or
  // exceeds half of it.
  CHECK(largest_distance(with, exact) < static_cast<double>(few.corrections) * 1e-3 * radius);
}

TEST_CASE("coarse-grid predictor: correction shrinks with the force, never grows") {
  const Scene scene = conductor_scene({{0.04, 0.05}, {0.06, 0.05}});
  std::vector<Vec2> coarse{{3e-7, 4e-7}, {0, 0}};  // N
  const std::vector<Vec2> wrong_by{{1e-8, -2e-8}, {3e-8, 0}}, fine{coarse[0] + wrong_by[0], coarse[1] + wrong_by[1]};
  effects::FloatingConductors field(scene, scripted([&](const auto&) { return fine; }));
  field.set_predictor(scripted([&](const auto&) { return coarse; }));
  const Bodies bodies = make_bodies(scene);
  const effects::ElectricalGroups groups = effects::electrical_groups(scene, {});
  const effects::NodeCharges charges{.charge = {1e-10, 1e-10}};
  field.predict(bodies, groups, charges);
  field.correct(field.solve(bodies, groups, charges));
  const auto added = [&](int body, Vec2 force) {
    coarse[body] = force;
    return plane(field.predict(bodies, groups, charges).force[body]) - force;
  };
  const auto is = [](Vec2 found, Vec2 expected) { return norm(found - expected) < 1e-6 * 1e-8; };  // Rounding.
  CHECK(is(added(0, {3e-7, 4e-7}), wrong_by[0]));
  CHECK(is(added(0, {-2e-7, 1.5e-7}), 0.5 * wrong_by[0]));  // The force is half as large, in any direction.
  CHECK(is(added(0, {9e-7, 12e-7}), wrong_by[0]));
  CHECK(is(added(0, {0, 0}), {0, 0}));
  CHECK(is(added(1, {1e-7, 0}), wrong_by[1]));  // This body had no force whose decrease could be measured.
}

TEST_CASE("coarse-grid predictor: rejected corrections conserve the charge") {
  Scene scene = resolved_spheres();
  scene.mechanics.position_tolerance *= 0.1;
  Simulation simulation(scene);
  const ConductorFrame start = simulation.now();
  const double before = start.charge_held + start.charge_drained;
  simulation.advance_to(0.1);
  const ConductorFrame frame = simulation.now();
  CHECK(simulation.counters().rejected_corrections > 0);
  CHECK(std::abs(frame.charge_held + frame.charge_drained - frame.charge_fed - before) < 1e-12 * frame.charge_fed);
  CHECK(frame.charge_fed == doctest::Approx(12 * 0.2e-9 * 0.1).epsilon(1e-12));
}

TEST_CASE("coarse-grid predictor: a restored run has identical bits") {
  const double every = 0.03;
  Simulation whole(resolved_spheres());
  std::vector<Checkpoint> checkpoints;
  for (int k = 1; k <= 3; ++k) {
    whole.advance_to(k * every);
    checkpoints.push_back(whole.checkpoint());
  }
  Simulation resumed(resolved_spheres());
  resumed.restore(checkpoints[0]);
  for (int k = 2; k <= 3; ++k) {
    resumed.advance_to(k * every);
    const Checkpoint same = resumed.checkpoint();
    CHECK(same.reals == checkpoints[k - 1].reals);
    CHECK(same.integers == checkpoints[k - 1].integers);
  }
}

TEST_CASE("default moving_tolerance: errors move bodies by below 0.2 tolerances") {
  const double until = 0.3, every = 0.01;
  const Scene scene = resolved_spheres();
  Simulation without_frames(scene), simulation(scene);
  without_frames.advance_to(until);
  // Mean time between solves (s).
  const double between_solves = until / static_cast<double>(without_frames.counters().corrections);
  std::vector<ConductorFrame> path;
  for (double time = every; time < until; time += every) {
    simulation.advance_to(time);
    path.push_back(simulation.now());
  }
  const auto forces = [&](double moving_tolerance) {
    Scene solved = scene;
    solved.field().moving_tolerance = moving_tolerance;
    const auto field = effects::make_floating_conductors(solved);
    std::vector<std::vector<Vec3>> found;
    for (const ConductorFrame& frame : path) {
      for (std::size_t i = 0; i < frame.position.size(); ++i) solved.conductors[i].position = frame.position[i];
      const Bodies bodies = make_bodies(solved);
      const effects::NodeCharges charges{.charge = frame.charge};
      found.push_back(field->solve(bodies, effects::groups_at_start(scene, bodies), charges).force);
    }
    return found;
  };
  const auto exact = forces(1e-10);
  const auto largest_displacement = [&](double moving_tolerance) {
    const auto found = forces(moving_tolerance);
    double largest = 0;
    for (std::size_t k = 0; k < found.size(); ++k)
      for (std::size_t i = 0; i < found[k].size(); ++i)
        largest = std::max(largest, norm(found[k][i] - exact[k][i]) * between_solves / drag);
    return largest;
  };
  const double usual = effects::usual_moving_tolerance(scene), bound = 0.2 * scene.mechanics.position_tolerance;
  CHECK(usual == doctest::Approx(1e-4));
  CHECK(largest_displacement(usual) < bound);
  CHECK(largest_displacement(10 * usual) > bound);  // The bound is close to the actual errors.
}

TEST_CASE("default moving_tolerance: grows as position_tolerance^2, 1e-5 to 1e-4") {
  Scene scene = resolved_spheres();
  const auto usual = [&](double radii) {
    scene.mechanics.position_tolerance = radii * radius;
    return effects::usual_moving_tolerance(scene);
  };
  CHECK(usual(1e-3) == doctest::Approx(1e-4));
  CHECK(usual(5e-4) == doctest::Approx(2.5e-5));
  CHECK(usual(2.5e-4) == 1e-5);  // The links have an error of this size.
  CHECK(usual(4e-3) == 1e-4);
  for (const auto& change : std::initializer_list<void (*)(Scene&)>{
           [](Scene& s) { s.mechanics.coupling = FieldCoupling::monolithic; },
           [](Scene& s) { s.mechanics.integrator = Integrator::euler; },
           [](Scene& s) { s.effects.add(effects::LeakageOptions{.conductivity = 1e-10}); }}) {
    Scene other = scene;
    change(other);
    CHECK(effects::usual_moving_tolerance(other) == 1e-5);
  }
}

}  // namespace predictor_test
