#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "tests/multipole_problems.hpp"
#include "tests/source_folder.hpp"

namespace multipole_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::multipole_problems;
using nlohmann::json;

namespace {

/// Two disks with charge 1 and potential 0 whose centres are at distance d along x.
LaplaceProblem pair(double first_radius, double second_radius, double d) {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};  // The plane has no box.
  problem.bodies = {{Disk{{0.3, 0.2}, first_radius}, 0}, {Disk{{0.3 + d, 0.2}, second_radius}, 1}};
  problem.groups = {{true, 1, 0}, {false, 0, 0}};
  return problem;
}

struct Reference {
  json expected;
  LaplaceProblem problem{.permittivity = 1};
  bool unbounded = false;
};

Reference read(const std::filesystem::path& path) {
  const json data = json::parse(std::ifstream(path));
  Reference reference;
  reference.expected = data["reference"];
  reference.unbounded = data["bc"] == "plane";
  LaplaceProblem& problem = reference.problem;
  const double side = reference.unbounded ? 1.0 : data["box"]["L"].get<double>();
  problem.size = {side, side};
  if (data["bc"] == "bottom_dirichlet") problem.sides[bottom].kind = Side::Kind::electrode;
  for (const json& disk : data["disks"]) problem.bodies.push_back({Disk{{disk["x"], disk["y"]}, disk["R"]}, 0});
  for (const json& conductor : data["conductors"]) {
    for (const int member : conductor["disks"]) problem.bodies[member].group = static_cast<int>(problem.groups.size());
    const bool floating = conductor["kind"] == "floating";
    problem.groups.push_back(
        {floating, floating ? conductor["Q"].get<double>() : 0, floating ? 0 : conductor["phi"].get<double>()});
  }
  return reference;
}

}  // namespace

TEST_CASE("multipole method, two disks: bipolar closed forms of potential, force") {
  // phi_1 - phi_2 = Q acosh((d^2 - R1^2 - R2^2) / (2 R1 R2)) / 2 pi, W = Q (phi_1 - phi_2) / 2, force = dW/dd.
  for (const double second_radius : {1.0, 0.3})
    for (const double gap : {10.0, 1.0, 0.1, 0.02}) {
      const double d = 1 + second_radius + gap;
      MultipoleSolver solver(options(1e-11, true));
      const LaplaceSolution solution = solver.solve(pair(1, second_radius, d));
      const double argument = (d * d - 1 - second_radius * second_radius) / (2 * second_radius);
      const double force = d / (4 * pi * second_radius * std::sqrt(argument * argument - 1));
      CHECK(solution.group_potential[0] == doctest::Approx(std::acosh(argument) / (2 * pi)).epsilon(1e-10));
      CHECK(solution.body_charge[1] == doctest::Approx(-1).epsilon(1e-10));
      CHECK(solution.body_force[0].x == doctest::Approx(force).epsilon(1e-10));
      CHECK(solution.body_force[1].x == doctest::Approx(-force).epsilon(1e-10));
      CHECK(std::abs(solution.body_force[0].y) < 1e-10 * force);
    }
}

TEST_CASE("multipole method: unknowns do not grow as gaps shrink to 1e-7 R") {
  long unknowns = 0;
  for (const double gap : {1e-2, 1e-3, 1e-5, 1e-7}) {
    CAPTURE(gap);
    const double d = 1.5 + gap;
    MultipoleSolver solver(options(1e-10, true));
    const LaplaceSolution solution = solver.solve(pair(1, 0.5, d));
    // As above, with cosh alpha - 1 = (d^2 - (R1 + R2)^2) / 2 R1 R2 from gap (2 R1 + 2 R2 + gap), without cancellation.
    const double t = gap * (2 * 1.5 + gap), root = std::sqrt(t * (t + 2));
    const double potential = std::log1p(t + root) / (2 * pi), force = d / (2 * pi * root);
    // Solver error relative to Q / 2 pi, and rounding of the given centres relative to the gap.
    const double accuracy = 1e-10 / (2 * pi * potential) + 4e-16 / gap;
    CHECK(solution.group_potential[0] == doctest::Approx(potential).epsilon(accuracy));
    CHECK(solution.body_force[0].x == doctest::Approx(force).epsilon(accuracy));
    CHECK(solution.body_force[1].x == doctest::Approx(-force).epsilon(accuracy));
    if (unknowns == 0) unknowns = solution.unknowns;
    CHECK(solution.unknowns <= unknowns);
  }
}

TEST_CASE("multipole method: disks at one potential may touch and overlap slightly") {
  // The union of two circles of radius 1 that intersect at +-i s is mapped to the outside of a wedge by ((z - i s) / (z
  // + i s))^p with p = pi / 2 beta, beta = 2 atan(s / (1 + c)), c = sqrt(1 - s^2). Its logarithmic capacity is s p, and
  // pi / 2 if the circles only touch. A distant disk takes the opposite charge: phi_1 - phi_2 = Q (ln(D / s p) + ln D)
  // / 2 pi up to (1/D)^2.
  const double far = 1e4;
  for (const double depth : {0.0, 1e-8, 1e-4, 9e-3}) {
    CAPTURE(depth);
    const double c = 1 - depth / 2, s = std::sqrt(1 - c * c);
    const double capacity = s > 0 ? s * pi / (4 * std::atan(s / (1 + c))) : pi / 2;
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {1, 1};
    problem.bodies = {{Disk{{-c, 0}, 1}, 0}, {Disk{{c, 0}, 1}, 0}, {Disk{{0, far}, 1}, 1}};
    problem.groups = {{true, 1, 0}, {true, -1, 0}};
    const LaplaceSolution solution = MultipoleSolver(options(1e-8, true)).solve(problem);
    const double expected = (std::log(far / capacity) + std::log(far)) / (2 * pi);
    // Solver error and (1/D)^2.
    CHECK(solution.group_potential[0] - solution.group_potential[1] == doctest::Approx(expected).epsilon(2e-8));
    CHECK(solution.body_charge[0] == doctest::Approx(0.5).epsilon(1e-7));
  }
}

TEST_CASE("multipole_unknowns: equals the number of unknowns of a solve") {
  LaplaceProblem problem = random_disks(12, {2, 1}, 0.08, 0.002);
  problem.bodies[3].group = problem.bodies[4].group;
  problem.groups[7] = {false, 0, 0.5};
  problem.groups[3] = {false, 0, 0};  // This group has no body.
  for (const int walls : {0, 5}) {
    set_walls(problem, walls, {});
    const MultipoleOptions o = options(1e-8);
    CHECK(multipole_unknowns(problem, o) == MultipoleSolver(o).solve(problem).unknowns);
  }
}

TEST_CASE("multipole method, tight cluster: every disk is an equipotential") {
  // Three disks with tiny gaps between each other and to a half-disk, one pair of them in one group. The error of V is
  // largest on a boundary.
  const double gap = 1e-4, side = 0.2 + gap;
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  const double height = 0.15 + 0.1 + gap;
  problem.bodies = {{Disk{{0.5, 0}, 0.15}, 0},
                    {Disk{{0.5, height}, 0.1}, 1},
                    {Disk{{0.5 + 0.5 * side, height + side * std::sqrt(0.75)}, 0.1}, 2},
                    {Disk{{0.5 - 0.5 * side, height + side * std::sqrt(0.75)}, 0.1}, 1}};
  problem.groups = {{false, 0, 0}, {true, 0.5, 0}, {true, -1, 0}};
  MultipoleSolver solver(options(1e-9));
  const LaplaceSolution solution = solver.solve(problem);
  double worst = 0;
  for (const Body& body : problem.bodies) {
    const Disk& disk = std::get<Disk>(body.shape);
    for (int k = 0; k < 100; ++k) {
      const double theta = 2 * pi * k / 100;
      // Slightly outside, where V is a sum: the field in the gap is up to 0.1 V / gap, times 1e-13.
      const Vec2 p = disk.centre + (1 + 1e-12) * disk.radius * Vec2{std::cos(theta), std::sin(theta)};
      if (p.y < 0) continue;
      worst = std::max(worst, std::abs(solver.potential(p) - solution.group_potential[body.group]));
    }
  }
  CHECK(worst < 1e-8);
  CHECK(std::abs(total_charge(solution)) < 1e-9);
}

TEST_CASE("multipole method: reference cases are reproduced to 1e-12") {
  const std::filesystem::path folder = std::filesystem::path(source_folder()) / "validation/data/reference-disks";
  int cases = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    CAPTURE(entry.path().filename().string());
    ++cases;
    const Reference reference = read(entry.path());
    const json& expected = reference.expected;
    MultipoleSolver solver(options(1e-12, reference.unbounded));
    const LaplaceSolution solution = solver.solve(reference.problem);
    double potential = 0, force = 0;
    for (const double phi : expected["phi_disk"]) potential = std::max(potential, std::abs(phi));
    for (const json& f : expected["force"]) force = std::max(force, std::hypot(f[0].get<double>(), f[1].get<double>()));
    // The files guarantee at least 12.5 digits of the largest value; the solver's tolerance is 1e-12.
    const double accuracy = 1e-12;
    for (std::size_t b = 0; b < reference.problem.bodies.size(); ++b) {
      const double phi = solution.group_potential[reference.problem.bodies[b].group];
      const Vec2 f{expected["force"][b][0], expected["force"][b][1]};
      CHECK(std::abs(phi - expected["phi_disk"][b].get<double>()) < accuracy * potential);
      CHECK(norm(solution.body_force[b] - f) < accuracy * force);
      CHECK(std::abs(solution.body_charge[b] - expected["Q_disk"][b].get<double>()) < accuracy);
    }
    CHECK(solution.energy == doctest::Approx(expected["energy"].get<double>()).epsilon(accuracy));
    for (const json& probe : expected["probes"])
      CHECK(std::abs(solver.potential({probe["x"], probe["y"]}) - probe["V"].get<double>()) < accuracy * potential);
  }
  CHECK(cases == 11);
}

TEST_CASE("multipole method and cut-cell solver: agree within the grid's error") {
  // S = 128, R = 9 cells, gaps of at least 4 cells. The capacitance has an error of 0.07 % at a gap of R/2
  // (docs/measurements/validation.json, R = 8, d/2R = 1.25), and the walls' different potentials contribute as much.
  LaplaceProblem problem = random_disks(8, {1, 1}, 0.07, 0.04);
  problem.groups[2] = {false, 0, 0.5};
  problem.bodies[4].group = problem.bodies[3].group;  // A floating group with two members, and one group without.
  problem.groups[4] = {false, 0, 0};
  for (const int walls : {0, 4, 3, 9}) {
    CAPTURE(walls);
    LaplaceProblem walled = problem;
    set_walls(walled, walls, {0.5, -1, 0, 2});
    CutCellOptions cutcell_options;
    cutcell_options.cells = 128;
    CutCellSolver cutcell(cutcell_options);
    MultipoleSolver multipole(options(1e-8));
    const LaplaceSolution rough = cutcell.solve(walled), exact = multipole.solve(walled);
    double potential = 0, force = 0;
    for (const double phi : exact.group_potential) potential = std::max(potential, std::abs(phi));
    for (const Vec2 f : exact.body_force) force = std::max(force, norm(f));
    for (std::size_t b = 0; b < walled.bodies.size(); ++b) {
      const int g = walled.bodies[b].group;
      CHECK(std::abs(rough.group_potential[g] - exact.group_potential[g]) < 1e-3 * potential);
      CHECK(norm(rough.body_force[b] - exact.body_force[b]) < 1e-2 * force);
      CHECK(std::abs(rough.body_charge[b] - exact.body_charge[b]) < 2e-3);
    }
    for (int s = 0; s < 4; ++s)
      if (std::isfinite(exact.side_charge[s])) CHECK(std::abs(rough.side_charge[s] - exact.side_charge[s]) < 2e-2);
  }
}

TEST_CASE("multipole forces: negative energy derivatives at constant charge") {
  LaplaceProblem problem = random_disks(6, {1, 1.2}, 0.08, 0.04);
  set_walls(problem, 12, {0, 0, 0, 0});
  MultipoleSolver solver(options(1e-12));
  const LaplaceSolution solution = solver.solve(problem);
  // Central differences with step 1e-4 at gaps of about 0.05: truncation 1e-8 W''' / 6, rounding 1e-12 / 1e-4.
  constexpr double step = 1e-4;
  const auto energy = [&](Vec2 shift) {
    LaplaceProblem moved = problem;
    std::get<Disk>(moved.bodies[1].shape).centre += shift;
    return solver.solve(moved).energy;
  };
  CHECK(solution.body_force[1].x ==
        doctest::Approx(-(energy({step, 0}) - energy({-step, 0})) / (2 * step)).epsilon(1e-5));
  CHECK(solution.body_force[1].y ==
        doctest::Approx(-(energy({0, step}) - energy({0, -step})) / (2 * step)).epsilon(1e-5));
}

TEST_CASE("multipole capacitance matrix: symmetric, zero row sums if insulated") {
  for (const int walls : {0, 6}) {
    LaplaceProblem problem = random_disks(4, {1, 1}, 0.09, 0.03);
    neutralize(problem);
    set_walls(problem, walls, {});
    MultipoleSolver solver(options(1e-10));
    const std::vector<double> c = capacitance_matrix(solver, problem);
    for (int i = 0; i < 4; ++i) {
      double row = 0;
      for (int j = 0; j < 4; ++j) {
        row += c[i * 4 + j];
        CHECK(c[i * 4 + j] == doctest::Approx(c[j * 4 + i]).epsilon(1e-8));
      }
      if (walls == 0) CHECK(std::abs(row) < 1e-9 * c[i * 4 + i]);
    }
  }
}

TEST_CASE("multipole method, unbounded plane: it is the limit of a large box") {
  // The images in an insulated box add the field of a dipole of size d: an energy of order (d / L)^2.
  MultipoleSolver plane(options(1e-11, true)), box(options(1e-11));
  const double exact = plane.solve(pair(1, 0.5, 3)).energy;
  double error[2];
  for (const int k : {0, 1}) {
    const double side = k == 0 ? 200 : 400;
    LaplaceProblem problem = pair(1, 0.5, 3);
    problem.size = {side, side};
    for (Body& body : problem.bodies) std::get<Disk>(body.shape).centre += Vec2{0.5 * side, 0.5 * side};
    error[k] = std::abs(box.solve(problem).energy - exact);
  }
  CHECK(error[0] < 1e-3 * exact);
  CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.05));
}

TEST_CASE("multipole method without ground: mean potential of bodies is zero") {
  LaplaceProblem problem = random_disks(5, {1, 1}, 0.08, 0.04);
  problem.bodies[4].group = 1;
  problem.groups.pop_back();
  neutralize(problem);
  MultipoleSolver solver(options(1e-10));
  const LaplaceSolution solution = solver.solve(problem);
  double sum = 0, charge = 0;
  for (const Body& body : problem.bodies) sum += solution.group_potential[body.group];
  CHECK(std::abs(sum) < 1e-9);
  for (std::size_t b = 0; b < 5; ++b)
    if (problem.bodies[b].group == 1) charge += solution.body_charge[b];
  CHECK(charge == doctest::Approx(problem.groups[1].charge).epsilon(1e-9));
  // potential() has the same level.
  const Vec2 beside = std::get<Disk>(problem.bodies[0].shape).centre + Vec2{0.08 + 1e-12, 0};
  CHECK(solver.potential(beside) == doctest::Approx(solution.group_potential[0]).epsilon(1e-8));
}

TEST_CASE("multipole method: errors are below the tolerance and the residual") {
  LaplaceProblem problem = random_disks(40, {1, 1}, 0.04, 0.01);
  set_walls(problem, 4, {});
  MultipoleSolver reference(options(1e-13));
  const LaplaceSolution exact = reference.solve(problem);
  double potential = 0, force = 0;
  for (const double phi : exact.group_potential) potential = std::max(potential, std::abs(phi));
  for (const Vec2 f : exact.body_force) force = std::max(force, norm(f));
  for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9}) {
    CAPTURE(tolerance);
    MultipoleSolver solver(options(tolerance));
    const LaplaceSolution solution = solver.solve(problem);
    double error = 0;
    for (std::size_t b = 0; b < 40; ++b) {
      error = std::max(error, std::abs(solution.group_potential[b] - exact.group_potential[b]) / potential);
      error = std::max(error, norm(solution.body_force[b] - exact.body_force[b]) / force);
    }
    CHECK(error < tolerance);
    CHECK(solution.residual < tolerance);
    CHECK(error < solution.residual);
  }
}

TEST_CASE("multipole method: a small force on a neutral disk is accurate") {
  LaplaceProblem problem = random_disks(1, {1, 1}, 0.0157, 0.1);
  std::get<Disk>(problem.bodies[0].shape).centre = {0.816, 0.681};
  problem.groups[0].charge = 0;
  for (const SideIndex side : {left, right}) problem.sides[side].kind = Side::Kind::electrode;
  problem.sides[left].potential = 1;
  const LaplaceSolution exact = MultipoleSolver(options(1e-13)).solve(problem);
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8}) {
    CAPTURE(tolerance);
    const LaplaceSolution found = MultipoleSolver(options(tolerance)).solve(problem);
    CHECK(largest_error(problem, found, exact, scales_of(problem, exact)) < tolerance);
  }
}

TEST_CASE("MultipoleSolver: history saves iterations, forget() removes it") {
  LaplaceProblem problem = random_disks(20, {1, 1}, 0.05, 0.02);
  set_walls(problem, 4, {});
  LaplaceProblem moved = problem;
  for (Body& body : moved.bodies) std::get<Disk>(body.shape).centre += Vec2{1e-4, -5e-5};
  MultipoleSolver solver(options(1e-8)), fresh(options(1e-8));
  solver.solve(problem);
  const LaplaceSolution warm = solver.solve(moved);
  solver.forget();
  const LaplaceSolution cold = solver.solve(moved), again = fresh.solve(moved);
  CHECK(warm.iterations < cold.iterations);
  for (std::size_t g = 0; g < 20; ++g) {
    CHECK(warm.group_potential[g] == doctest::Approx(cold.group_potential[g]).epsilon(1e-7));
    CHECK(cold.group_potential[g] == again.group_potential[g]);
  }
}

TEST_CASE("MultipoleOptions: values out of range are refused") {
  CHECK_THROWS_AS(MultipoleSolver(options(0)), InputError);
  CHECK_THROWS_AS(MultipoleSolver(options(1e-15)), InputError);
  CHECK_THROWS_AS(MultipoleSolver(options(NAN)), InputError);
  MultipoleOptions none;
  none.cells = 0;
  CHECK_THROWS_AS(MultipoleSolver{none}, InputError);
}

TEST_CASE("MultipoleSolver: field and potential before a solve throw Failure") {
  MultipoleSolver solver;
  CHECK_THROWS_AS(solver.field(), Failure);
  CHECK_THROWS_AS(solver.potential({0, 0}), Failure);
}

TEST_CASE("MultipoleSolver::field: potential and covering disk at cell centres") {
  LaplaceProblem problem = random_disks(3, {2, 1}, 0.1, 0.1);
  set_walls(problem, 4, {});
  MultipoleOptions o = options(1e-8);
  o.cells = 40;
  MultipoleSolver solver(o);
  const LaplaceSolution solution = solver.solve(problem);
  const Field field = solver.field();
  REQUIRE(field.nx == 40);
  REQUIRE(field.ny == 20);
  for (const auto& [i, j] : {std::pair{3, 7}, {39, 19}, {20, 0}}) {
    const Vec2 p{(i + 0.5) * 0.05, (j + 0.5) * 0.05};
    CHECK(field.value[j * 40 + i] == doctest::Approx(solver.potential(p)));
  }
  const Vec2 centre = std::get<Disk>(problem.bodies[1].shape).centre;
  const int inside = static_cast<int>(centre.y / 0.05) * 40 + static_cast<int>(centre.x / 0.05);
  CHECK(field.body[inside] == 1);
  CHECK(field.value[inside] == solution.group_potential[1]);
  // 3 pi (0.1 / 0.05)^2 = 38 of 800 cells are covered.
  CHECK(std::count(field.body.begin(), field.body.end(), -1) > 700);
}

TEST_CASE("multipole method: impossible shapes, overlaps and sides are refused") {
  LaplaceProblem problem = random_disks(2, {1, 1}, 0.1, 0.1);
  problem.groups[0] = {false, 0, 0};
  MultipoleOptions o;
  SUBCASE("bar") { problem.bodies[0].shape = Bar{{0.2, 0.2}, {0.4, 0.2}, 0.1}; }
  SUBCASE("ring") { problem.bodies[0].shape = Ring{{0.5, 0.5}, 0.5}; }
  SUBCASE("overlap") {
    problem.bodies[0].shape = Disk{std::get<Disk>(problem.bodies[1].shape).centre + Vec2{0.1, 0}, 0.05};
  }
  SUBCASE("overlap of one group by more than 1 %") {
    problem.bodies[0].shape = Disk{std::get<Disk>(problem.bodies[1].shape).centre + Vec2{0.197, 0}, 0.1};
    problem.bodies[1].group = 0;
    problem.groups.pop_back();
  }
  SUBCASE("disk across a side") { problem.bodies[0].shape = Disk{{0.5, 0.02}, 0.05}; }
  SUBCASE("disk that touches a side of another potential") {
    problem.bodies[0].shape = Disk{{0.5, 0.05}, 0.05};
    problem.sides[bottom] = {Side::Kind::electrode, 1, {}};
  }
  SUBCASE("disk outside") { problem.bodies[0].shape = Disk{{0.5, -2}, 0.05}; }
  SUBCASE("half-disk at another potential than its electrode") {
    problem.bodies[0].shape = Disk{{0.5, 0}, 0.05};
    problem.sides[bottom] = {Side::Kind::electrode, 1, {}};
  }
  SUBCASE("potential profile") {
    problem.sides[top] = {Side::Kind::electrode, 0, [](Vec2 p) { return p.x; }};
  }
  SUBCASE("electrode sides in the plane") {
    problem.sides[top].kind = Side::Kind::electrode;
    o.unbounded = true;
  }
  MultipoleSolver solver(o);
  CHECK_THROWS_AS(solver.solve(problem), InputError);
}

}  // namespace multipole_test
