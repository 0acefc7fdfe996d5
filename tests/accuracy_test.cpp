#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/accuracy/gaps.hpp"
#include "solvers/laplace/accuracy/grids.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "tests/message.hpp"
#include "tests/random_placement.hpp"

namespace accuracy_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// Problem of three disks above an electrode, two of them at a gap of half a radius.
LaplaceProblem three_disks() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.sides[bottom].kind = Side::Kind::electrode;
  problem.bodies = {{Disk{{0.31, 0.42}, 0.08}, 0}, {Disk{{0.51, 0.42}, 0.08}, 1}, {Disk{{0.68, 0.71}, 0.06}, 2}};
  problem.groups = {{true, 1, 0}, {true, -0.5, 0}, {false, 0, 0.2}};
  return problem;
}

std::string refusal(const LaplaceProblem& problem, const AccuracyRequest& request) {
  return message_of<InputError>([&] { solve_to_accuracy(problem, request); });
}

}  // namespace

TEST_CASE("scales_of: potential range, largest charge and force (of moving disks)") {
  LaplaceProblem problem = three_disks();
  problem.bodies.push_back({Bar{{0.1, 0.8}, {0.2, 0.8}, 0.05}, 2});
  LaplaceSolution solution;
  solution.group_potential = {3, -2, 0.2};  // With the electrode at 0 the range is 5.
  solution.body_charge = {1, -0.5, 0.1, -4};
  solution.body_force = {{0.3, 0.4}, {0, 0.1}, {0, 0}, {90, 0}};  // The force on a bar does not count.
  const Scales scales = scales_of(problem, solution);
  CHECK(scales.potential == 5);
  CHECK(scales.charge == 4);
  CHECK(scales.force == 0.5);
  LaplaceSolution other = solution;
  CHECK(largest_error(problem, other, solution, scales) == 0);
  other.group_potential[1] = -2.05;
  CHECK(largest_error(problem, other, solution, scales) == doctest::Approx(0.01));
  other.body_charge[0] = 1.08;
  CHECK(largest_error(problem, other, solution, scales) == doctest::Approx(0.02));
  other.body_force[2] = {0.03, 0.04};
  CHECK(largest_error(problem, other, solution, scales) == doctest::Approx(0.1));
  other.body_force[3] = {0, 0};
  CHECK(largest_error(problem, other, solution, scales) == doctest::Approx(0.1));
  // The largest value is the unit even if it is small; rounding errors are ignored.
  solution.body_charge.assign(4, 0);
  solution.body_force.assign(4, {0, 0});
  solution.body_charge[1] = 1e-6, solution.body_force[1] = {0, 1e-6};
  const Scales small = scales_of(problem, solution);
  CHECK(small.charge == 1e-6);
  CHECK(small.force == 1e-6);
  other = solution;
  other.body_force[0] = {1e-8, 0};
  CHECK(largest_error(problem, other, solution, small) == doctest::Approx(0.01));
  other.body_force[0] = {0.9 * share_of_rounding * 25, 0};
  other.body_charge[0] = 0.9 * share_of_rounding * 5;
  CHECK(largest_error(problem, other, solution, small) == 0);
  // Forces on electrodes do not enter the unit.
  other.body_force[0] = {0, 0}, other.body_force[1] = {0, 2e-6};
  problem.movable = 1;
  CHECK(scales_of(problem, solution).force == 0);
  CHECK(largest_error(problem, other, solution, scales_of(problem, solution)) < 1e-4);
}

TEST_CASE("Grids: cell counts give whole square cells on all multigrid levels") {
  const Grids square({2, 2}), oblong({0.05, 0.03});
  CHECK(square.at_least(1) == 32);
  CHECK(square.at_least(33) == 48);
  CHECK(square.at_least(1000) == 1024);
  CHECK(square.at_most(1000) == 960);
  // Three cells across for five along: multiples of 5, and of 16 as in all grids.
  for (const int cells : {1, 200, 555, 3000}) {
    const int fine = oblong.at_least(cells);
    CHECK(fine >= cells);
    CHECK(fine % (5 * 16) == 0);
    CHECK(oblong.at_most(fine) == fine);
  }
  CHECK_THROWS_AS(Grids({1, std::numbers::sqrt2}), InputError);
  CHECK_THROWS_AS(oblong.at_most(100), InputError);
}

TEST_CASE("narrowest: finds the smallest gap between different potentials") {
  LaplaceProblem problem = three_disks();
  CHECK(narrowest(problem).gap == doctest::Approx(0.04));
  CHECK(narrowest(problem).radius == 0.08);
  // With one potential, the distance to the electrode is 0.34, limited to two radii of the smallest disk.
  problem.bodies[1].group = 0;
  CHECK(narrowest(problem).gap == doctest::Approx(0.12));
  CHECK(narrowest(problem).radius == 0.06);
  problem.bodies[2].shape = Disk{{0.68, 0.07}, 0.06};
  CHECK(narrowest(problem).gap == doctest::Approx(0.01));  // The gap to the electrode.
  problem.groups[2].potential = 0;                         // The disk has the electrode's potential.
  CHECK(narrowest(problem).gap == doctest::Approx(0.12));
  problem.bodies.push_back({Ring{{0.5, 0.5}, 0.6}, 1});
  CHECK(narrowest(problem).gap == doctest::Approx(0.6 - 0.06 - std::hypot(0.18, 0.43)));
  // The error is of second order if a cell fits into the gap. cell_for() inverts difficulty().
  for (const double cell : {0.001, 0.01, 0.5})
    CHECK(cell_for({0.04, 0.08}, difficulty({0.04, 0.08}, cell)) == doctest::Approx(cell));
  CHECK(difficulty({0.04, 0.08}, 0.01) == doctest::Approx(4 * difficulty({0.04, 0.08}, 0.005)));
}

TEST_CASE("solve_to_accuracy: cut-cell and multipole errors stay below the request") {
  const LaplaceProblem problem = three_disks();
  const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-12}).solve(problem);
  const Scales scales = scales_of(problem, exact);
  for (const double accuracy : {1e-2, 1e-3, 1e-6})
    for (const Method method : {Method::cut_cell, Method::multipole}) {
      if (method == Method::cut_cell && accuracy < 1e-3) continue;
      CAPTURE(accuracy);
      const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = accuracy, .method = method});
      CHECK(found.choice.method == method);
      const double realised = largest_error(problem, found.solution, exact, scales);
      CHECK(realised <= accuracy);
      CHECK(realised <= found.choice.estimate);
      CHECK(found.choice.estimate <= accuracy);
      // The solver belongs to the solution, and the estimate is reproducible.
      CHECK(found.solver->field().nx == found.choice.cells);
      CHECK(estimated_error(problem, found.choice, {}) == found.choice.estimate);
    }
}

TEST_CASE("accuracy: rounding differences between equal potentials count as zero") {
  LaplaceProblem problem{.size = {0.02, 0.02}, .permittivity = 4e-11};  // An insulated box.
  problem.groups = {{.floating = false, .potential = -100}, {.charge = 0}};
  problem.bodies = {{Disk{{0.0160657, 0.0149699}, 1.772e-4}, 0}, {Disk{{0.0160165, 0.0145738}, 2.218e-4}, 1}};
  const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = 1e-6, .method = Method::multipole});
  CHECK(found.choice.estimate <= 1e-6);
  CHECK(found.solution.group_potential[1] == doctest::Approx(-100).epsilon(1e-13));
  CHECK(scales_of(problem, found.solution).potential == 0);
  CHECK(scales_of(problem, {.group_potential = {-100, -100 + 1e-9}, .body_charge = {0, 0}, .body_force = {{}, {}}})
            .potential > 0);
}

TEST_CASE("multipole accuracy: errors below the request, median above 5 % of it") {
  // The median ratio of some scenes exceeds 5 % of the request: 0.1 to 0.2 in docs/validation.md. This
  // holds also if the charge of a half-disk on an electrode, an integral over a part of its circle, dominates.
  for (const double accuracy : {1e-2, 1e-4, 1e-8}) {
    CAPTURE(accuracy);
    std::vector<double> ratio;
    for (int scene = 1; scene <= 9; ++scene) {
      random_placement::Random random(static_cast<std::uint64_t>(scene));
      LaplaceProblem problem = three_disks();
      if (scene % 3 == 0) {
        problem.bodies.push_back({Disk{{0.5, 0}, 0.1}, 3});
        problem.groups.push_back({false, 0, 0});
      }
      for (int k = 0; k < 200; ++k) {
        const Disk disk{{random(0.06, 0.94), random(0.06, 0.94)}, 0.05};
        if (problem.bodies.size() < 15) random_placement::add_if_free(problem, disk, 0.01, random);
      }
      const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-12}).solve(problem);
      const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = accuracy, .method = Method::multipole});
      ratio.push_back(largest_error(problem, found.solution, exact, scales_of(problem, exact)) / accuracy);
    }
    std::ranges::sort(ratio);
    CHECK(ratio[4] > 0.05);
    CHECK(ratio.back() < 1);
  }
}

TEST_CASE("multipole accuracy: the request is met at gaps of 1e-6 radii") {
  // A neutral disk lies at an electrode or next to a pair of charged disks. Its force is that of a gap whose potential
  // difference is 0.1 % of that at a gap of one radius.
  LaplaceProblem near_charged{.permittivity = 1};
  near_charged.size = {0.02, 0.02};
  near_charged.sides[top].kind = Side::Kind::electrode;
  LaplaceProblem near_pair = near_charged;
  near_charged.sides[right].kind = Side::Kind::electrode;
  near_charged.bodies = {{Disk{{0.012619, 0.016521}, 0.001}, 0}, {Disk{{0.0023012, 0.018999999}, 0.001}, 1}};
  near_charged.groups = {{true, 1, 0}, {true, 0, 0}};
  near_pair.sides[top].potential = -120;
  near_pair.bodies = {{Disk{{0.009097083989283446, 0.015961195600565657}, 0.001}, 0},
                      {Disk{{0.007744057405565945, 0.014007099717648196}, 0.001}, 1},
                      {Disk{{0.015997539991561744, 0.018999999}, 0.001}, 2}};
  near_pair.groups = {{true, 1, 0}, {true, 1, 0}, {true, 0, 0}};
  for (const LaplaceProblem& problem : {near_charged, near_pair})
    for (const double accuracy : {1e-2, 1e-3, 1e-4}) {
      CAPTURE(accuracy);
      const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-9}).solve(problem);
      const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = accuracy, .method = Method::multipole});
      CHECK(largest_error(problem, found.solution, exact, scales_of(problem, exact)) < accuracy);
    }
}

TEST_CASE("multipole accuracy: met where charges or forces vanish by symmetry") {
  LaplaceProblem plates{.permittivity = 1};
  plates.size = {1, 1};
  plates.sides[left].kind = plates.sides[right].kind = Side::Kind::electrode;
  plates.sides[right].potential = 1;
  LaplaceProblem level = plates;
  plates.bodies = {{Disk{{0.5, 0.4}, 0.1}, 0}, {Disk{{0.5, 0.7}, 0.1}, 0}};
  LaplaceProblem half_way = plates;
  plates.groups = {{true, 0, 0}};
  half_way.groups = {{false, 0, 0.5}};
  level.sides[left].potential = 1;
  level.bodies = {{Disk{{0.4, 0.7}, 0.1}, 0}};
  level.groups = {{false, 0, 1}};
  for (const LaplaceProblem& problem : {plates, half_way, level})
    for (const double accuracy : {1e-2, 1e-8}) {
      const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-12}).solve(problem);
      const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = accuracy, .method = Method::multipole});
      CHECK(found.choice.estimate <= accuracy);
      CHECK(largest_error(problem, found.solution, exact, scales_of(problem, exact)) < accuracy);
    }
}

TEST_CASE("multipole accuracy: requests of 0.1 to 0.001 are met for neutral disks") {
  LaplaceProblem problem{.size = {12.1647, 12.1647}, .permittivity = 1};
  problem.sides[left] = {Side::Kind::electrode, 400, {}};
  problem.sides[right] = {Side::Kind::electrode, 0, {}};
  constexpr double radius = 0.424418;
  for (const Vec2 centre : {Vec2{6.12457, 3.69672},
                            {10.6732, 6.62813},
                            {10.43004, 1.76828},
                            {10.28263, 4.84661},
                            {7.24234, 10.87593},
                            {0.900376, 5.06128},
                            {6.330655, 1.84637},
                            {7.298816, 9.4265},
                            {5.918217, 10.122176},
                            {7.371377, 5.62745}}) {
    problem.bodies.push_back({Disk{centre, radius}, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({.charge = 0});
  }
  const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-13}).solve(problem);
  const Scales scales = scales_of(problem, exact);
  for (const double accuracy : {0.1, 0.03, 0.02, 0.01, 0.005, 0.001}) {
    CAPTURE(accuracy);
    const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = accuracy, .method = Method::multipole});
    CHECK(largest_error(problem, found.solution, exact, scales) <= accuracy);
  }
}

TEST_CASE("cut-cell accuracy: met if potentials differ by only 1e-4 of their value") {
  LaplaceProblem problem = three_disks();
  constexpr double level = 1e4;  // The potentials differ by about 1.
  for (Side& side : problem.sides) side.potential += level;
  for (Group& group : problem.groups) group.potential += level;
  const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-13}).solve(problem);
  const AccurateSolution found = solve_to_accuracy(problem, {.accuracy = 3e-3, .method = Method::cut_cell});
  CHECK(largest_error(problem, found.solution, exact, scales_of(problem, exact)) <= 3e-3);
}

TEST_CASE("accuracy for a run: an expected gap below the initial needs more cells") {
  AccuracyRequest request{.accuracy = 1e-2, .method = Method::cut_cell};
  const int now = solve_to_accuracy(three_disks(), request).choice.cells;
  request.least_gap = 0.01;  // A gap smaller by 4 has 4^(3/2) times the error and needs 4^(3/4) times the cells.
  CHECK(solve_to_accuracy(three_disks(), request).choice.cells > 2 * now);
  request.least_gap = 0.05;
  CHECK(solve_to_accuracy(three_disks(), request).choice.cells == now);
}

TEST_CASE("predict_choice: takes the requested or the only possible field method") {
  LaplaceProblem problem = three_disks();
  CHECK(predict_choice(problem, {.accuracy = 1e-8}).method == Method::multipole);
  CHECK(predict_choice(problem, {.accuracy = 1e-3, .method = Method::cut_cell}).method == Method::cut_cell);
  problem.bodies.push_back({Bar{{0.1, 0.8}, {0.2, 0.8}, 0.05}, 2});
  CHECK(predict_choice(problem, {.accuracy = 1e-2}).method == Method::cut_cell);
  CHECK_THROWS_AS(predict_choice(problem, {.accuracy = 1e-2, .method = Method::multipole}), InputError);
}

namespace {

/// Problem of a neutral disk between plates, optionally next to a grounded disk.
LaplaceProblem neutral_disk(bool near_grounded) {
  LaplaceProblem problem{.size = {0.032, 0.032}, .permittivity = 2e-11};
  problem.sides[left] = {Side::Kind::electrode, near_grounded ? 9.0 : 1000.0, {}};
  problem.sides[right].kind = Side::Kind::electrode;
  problem.groups = {{.charge = 0}};
  problem.bodies = {{Disk{{0.014687708, 0.0158595154}, 0.000775}, 0}};
  if (!near_grounded) return problem;
  problem.bodies = {{Disk{{0.0086826647, 0.0249779814}, 0.000554218}, 0},
                    {Disk{{0.0148815666, 0.0090782972}, 0.001574038}, 1}};
  problem.groups.push_back({.floating = false, .potential = 0});
  problem.movable = 1;  // The grounded disk is an electrode.
  return problem;
}

}  // namespace

TEST_CASE("tiny force on a neutral disk: is accurate, or cut-cell refuses it") {
  for (const bool near_grounded : {false, true}) {
    CAPTURE(near_grounded);
    const LaplaceProblem problem = neutral_disk(near_grounded);
    const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-13}).solve(problem);
    const Scales scales = scales_of(problem, exact);
    for (const double accuracy : {1e-1, 1e-2, 1e-3}) {
      CAPTURE(accuracy);
      const AccurateSolution spectral = solve_to_accuracy(problem, {.accuracy = accuracy, .method = Method::multipole});
      CHECK(largest_error(problem, spectral.solution, exact, scales) <= accuracy);
      const AccuracyRequest request{.accuracy = accuracy, .method = Method::cut_cell, .most_cells = 768};
      const std::string sentence = refusal(problem, request);
      // The force on the isolated disk is 1e-6 of eps V^2 / L, below the error of any grid.
      if (!near_grounded) CHECK(sentence != "");
      if (sentence == "")
        CHECK(largest_error(problem, solve_to_accuracy(problem, request).solution, exact, scales) <= accuracy);
    }
  }
  const std::string sentence =
      refusal(neutral_disk(false), {.accuracy = 0.01, .method = Method::cut_cell, .most_cells = 768});
  CHECK(sentence.find("field.accuracy = 0.01 cannot be met") == 0);
  CHECK(sentence.find("field.method = \"multipole\" can do it") != std::string::npos);
}

TEST_CASE("accuracy out of reach: the error message states one that can be met") {
  const std::string grids = refusal(three_disks(), {.accuracy = 1e-6, .method = Method::cut_cell, .most_cells = 256});
  CHECK(grids.find("1e-06 cannot be met: with 256 cells") != std::string::npos);
  // The stated accuracy is met.
  const double possible = std::stod(grids.substr(grids.find("about ") + 6));
  CHECK(refusal(three_disks(), {.accuracy = possible, .method = Method::cut_cell, .most_cells = 256}) == "");
  CHECK(refusal(three_disks(), {.accuracy = 1e-13}).find("between 1e-12 and 0.1") != std::string::npos);
}

TEST_CASE("charges and potentials all zero: both field methods give potential zero") {
  LaplaceProblem problem = three_disks();
  for (Group& group : problem.groups) group = {.floating = group.floating};
  for (const Method method : {Method::cut_cell, Method::multipole})
    CHECK(solve_to_accuracy(problem, {.method = method}).solution.group_potential[0] == doctest::Approx(0));
}

}  // namespace accuracy_test
