#include <doctest/doctest.h>

#include <limits>

#include "solvers/error.hpp"
#include "solvers/laplace/problem.hpp"

namespace laplace_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// Valid problem of two disks with charges +1 and -1 in an insulated box.
LaplaceProblem neutral_pair() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {10, 10};
  problem.bodies = {{Disk{{3, 5}, 1}, 0}, {Disk{{7, 5}, 1}, 1}};
  problem.groups = {{.charge = 1}, {.charge = -1}};
  return problem;
}

/// Solver without a field: a given matrix determines the charges. It tests functions that use the interface.
class MatrixSolver : public LaplaceSolver {
 public:
  explicit MatrixSolver(std::vector<double> matrix) : matrix_(std::move(matrix)) {}
  LaplaceSolution solve(const LaplaceProblem& problem) override {
    const std::size_t n = problem.groups.size();
    LaplaceSolution solution;
    for (const Body& body : problem.bodies) {
      double charge = 0, members = 0;
      for (std::size_t j = 0; j < n; ++j) charge += matrix_[body.group * n + j] * problem.groups[j].potential;
      for (const Body& other : problem.bodies) members += other.group == body.group;
      for (const Side& side : problem.sides) charge += side.potential_at({0, 0});
      solution.body_charge.push_back(charge / members);
    }
    return solution;
  }
  Field field() const override { return {}; }
  void forget() override {}

 private:
  std::vector<double> matrix_;
};

}  // namespace

TEST_CASE("LaplaceProblem: a neutral pair in an insulated box is valid, no ground") {
  const LaplaceProblem problem = neutral_pair();
  CHECK_NOTHROW(problem.check());
  CHECK_FALSE(problem.has_ground());
}

TEST_CASE("has_ground: true for an electrode side or a body of given potential") {
  LaplaceProblem with_side = neutral_pair();
  with_side.sides[top].kind = Side::Kind::electrode;
  CHECK(with_side.has_ground());

  LaplaceProblem with_body = neutral_pair();
  with_body.groups[1] = {.floating = false, .potential = 3};
  CHECK(with_body.has_ground());
}

TEST_CASE("has_ground: false for a fixed group without a body") {
  LaplaceProblem problem = neutral_pair();
  problem.groups.push_back({.floating = false});
  CHECK_FALSE(problem.has_ground());
  CHECK_NOTHROW(problem.check());
}

TEST_CASE("has_ground: a fixed node grounds groups joined to it by conductances") {
  LaplaceProblem problem = neutral_pair();
  problem.groups[0].charge = 5;
  problem.groups.push_back({});                   // 2, a node between two resistors.
  problem.groups.push_back({.floating = false});  // 3, a supply.
  const Coupling supply{2, 3, 1.0};
  problem.couplings = {supply, {1, 2, 1e-12}};
  CHECK(problem.has_ground());
  CHECK_NOTHROW(problem.check());
  problem.couplings = {supply, {1, 2, 0.0}};
  CHECK_FALSE(problem.has_ground());
  CHECK_THROWS_AS(problem.check(), InputError);
  problem.couplings = {supply};
  CHECK_FALSE(problem.has_ground());
  CHECK_THROWS_AS(problem.check(), InputError);
}

TEST_CASE("LaplaceProblem::check: charge of a node tied to a source is not counted") {
  LaplaceProblem problem = neutral_pair();
  problem.groups.push_back({.charge = 7});  // 2: its charge comes from the supply, and it is not in the field.
  problem.groups.push_back({.floating = false});
  problem.couplings = {{2, 3, 1.0}};
  CHECK_NOTHROW(problem.check());
}

TEST_CASE("coupled_sets: chains of conductances above the minimum join groups") {
  LaplaceProblem problem{.permittivity = 1};
  problem.groups.resize(6);
  problem.couplings = {{4, 5, 1e-3}, {1, 4, 1.0}, {2, 5, 1.0}, {0, 3, 0.0}};
  CHECK(coupled_sets(problem) == std::vector<int>{0, 1, 1, 3, 1, 1});
  CHECK(coupled_sets(problem, 0.1) == std::vector<int>{0, 1, 2, 3, 1, 2});
}

TEST_CASE("LaplaceProblem::check: a net charge needs a ground") {
  LaplaceProblem problem = neutral_pair();
  problem.groups[1].charge = -0.9;
  CHECK_THROWS_AS(problem.check(), InputError);
  problem.sides[left].kind = Side::Kind::electrode;
  CHECK_NOTHROW(problem.check());
}

TEST_CASE("LaplaceProblem::check: charges that cancel up to rounding are neutral") {
  LaplaceProblem problem = neutral_pair();
  problem.bodies.push_back({Disk{{5, 8}, 1}, 2});
  problem.groups = {{.charge = 0.1}, {.charge = 0.2}, {.charge = -0.3}};  // The sum is 5.6e-17
  CHECK_NOTHROW(problem.check());
}

TEST_CASE("LaplaceProblem::check: malformed problems are refused") {
  LaplaceProblem problem = neutral_pair();
  SUBCASE("box without width") { problem.size.x = 0; }
  SUBCASE("permittivity not positive") { problem.permittivity = -1; }
  SUBCASE("permittivity not given") { problem.permittivity = LaplaceProblem().permittivity; }
  SUBCASE("body of a group that does not exist") { problem.bodies[0].group = 2; }
  SUBCASE("body of a negative group") { problem.bodies[0].group = -1; }
  SUBCASE("radius not positive") { problem.bodies[0].shape = Disk{{3, 5}, 0}; }
  SUBCASE("ring without radius") { problem.bodies[0].shape = Ring{{3, 5}, -2}; }
  SUBCASE("bar without length") { problem.bodies[0].shape = Bar{{1, 1}, {1, 1}, 0.5}; }
  SUBCASE("bar without width") { problem.bodies[0].shape = Bar{{1, 1}, {2, 1}, 0}; }
  SUBCASE("position not a number") { problem.bodies[0].shape = Disk{{std::numeric_limits<double>::quiet_NaN(), 5}, 1}; }
  SUBCASE("charge not finite") { problem.groups[0].charge = std::numeric_limits<double>::infinity(); }
  SUBCASE("floating group without a body") { problem.groups.push_back({}); }
  SUBCASE("coupling to a group that does not exist") { problem.couplings = {{0, 2, 1.0}}; }
  SUBCASE("coupling of a group to itself") { problem.couplings = {{1, 1, 1.0}}; }
  SUBCASE("negative capacitance") { problem.couplings = {{0, 1, -1.0}}; }
  SUBCASE("capacitance not finite") { problem.couplings = {{0, 1, std::numeric_limits<double>::infinity()}}; }
  SUBCASE("floating groups without a body, coupled to each other only") {
    problem.groups.resize(4);
    problem.couplings = {{2, 3, 1.0}};
  }
  SUBCASE("floating group without a body, coupled by nothing") {
    problem.groups.resize(3);
    problem.couplings = {{1, 2, 0.0}};
  }
  SUBCASE("potential profile on an insulating side") {
    problem.sides[left].profile = [](Vec2) { return 1.0; };
  }
  CHECK_THROWS_AS(problem.check(), InputError);
}

TEST_CASE("capacitance_matrix: sums charges over members, other groups at 0 V") {
  LaplaceProblem problem = neutral_pair();
  problem.bodies.push_back({Disk{{5, 8}, 1}, 0});  // Group 0 has two members.
  problem.sides[left] = {.kind = Side::Kind::electrode, .potential = 7, .profile = [](Vec2) { return 7.0; }};
  MatrixSolver solver({4, -1, -3, 5});  // An asymmetric matrix distinguishes rows from columns.
  CHECK(capacitance_matrix(solver, problem) == std::vector<double>{4, -1, -3, 5});
}

}  // namespace laplace_test
