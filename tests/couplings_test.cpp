#include <doctest/doctest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "solvers/laplace/circuit.hpp"
#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/network_factors.hpp"
#include "tests/dense_algebra.hpp"

namespace couplings_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double tolerance = 1e-9;  // Tolerance of the solver.
constexpr double eps = 4e-11;

struct Random {
  std::mt19937_64 generator{11};
  double operator()(double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  }
  int index(int count) { return static_cast<int>((*this)(0, count)); }
};

/// Problem of `count` random disks in a box of 64 cells, at least a cell apart, with charges of up to eps. Potentials
/// are of the order of 1 V. Group 0 is a bar along the bottom at 0 V.
LaplaceProblem random_disks(int count) {
  Random random;
  LaplaceProblem problem;
  problem.size = {64, 64};
  problem.permittivity = eps;
  problem.bodies = {{Bar{{20, 1}, {44, 1}, 4}, 0}};
  problem.groups = {{.floating = false}};
  while (static_cast<int>(problem.bodies.size()) <= count) {
    const double radius = random(1.2, 3.0);
    const Disk disk{{random(5, 59), random(7, 59)}, radius};
    if (!std::all_of(problem.bodies.begin(), problem.bodies.end(),
                     [&](const Body& body) { return gap(disk, body.shape) > 1; }))
      continue;
    problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({.charge = random(-1, 1) * eps});
  }
  return problem;
}

/// Problem without a ground: the bar floats, and its charge makes the sum of charges zero.
LaplaceProblem ungrounded(LaplaceProblem problem) {
  problem.groups[0] = {};
  double sum = 0;
  for (const Group& group : problem.groups) sum += group.floating ? group.charge : 0.0;
  problem.groups[0].charge = -sum;
  return problem;
}

/// Couples each disk to the previous one (chain) or to a random previous one (tree).
void couple(LaplaceProblem& problem, double capacitance, bool chain = false) {
  Random random;
  const int disks = static_cast<int>(problem.bodies.size()) - 1;
  for (int disk = 2; disk <= disks; ++disk)
    problem.couplings.push_back({chain ? disk - 1 : 1 + random.index(disk - 1), disk, capacitance});
}

CutCellSolver solver(double to = tolerance, int threads = 1) {
  return CutCellSolver({.cells = 64, .tolerance = to, .threads = threads});
}
LaplaceSolution solve(const LaplaceProblem& problem) { return solver().solve(problem); }
LaplaceSolution solve_assembled(const LaplaceProblem& problem) {
  return CutCellSolver({.cells = 64,
                        .tolerance = tolerance,
                        .threads = 1,
                        .linear_solver = CutCellOptions::LinearSolver::assembled})
      .solve(problem);
}

/// Bound on errors of potentials (V). CG stops when its estimate of the error in the energy norm, sqrt(x'Ax), is
/// `tolerance` times the solution's. e'Ae is at least e_g^2 times the capacitance of group g. This capacitance exceeds
/// 1 here (2 pi / ln(64 / 1.2) = 1.6). The estimate may be a few times too small.
double uncertainty(const LaplaceSolution& solution) {
  return 5 * tolerance * std::sqrt(2 * std::abs(solution.energy) / eps);
}

/// Charge of the field on each group.
std::vector<double> group_charges(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  std::vector<double> charge(problem.groups.size(), 0.0);
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) charge[problem.bodies[b].group] += solution.body_charge[b];
  return charge;
}

/// Bound on rounding in a sum of all charges (C/m). Potentials are rounded to 2^-52 of the largest, and each link
/// carries this times its conductance. The largest conductances belong to cells whose centre nearly lies on a surface.
double rounding_of_charges(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  Level level(problem, 64, 64);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  double conductance = 0, largest = 0;
  for (const FluidLink& link : level.links) conductance += link.conductance;
  for (const PairLink& link : level.pairs) conductance += link.conductance;
  for (const double potential : solution.group_potential) largest = std::max(largest, std::abs(potential));
  return problem.permittivity * 0x1p-52 * conductance * largest;
}

/// Solution of (C + K) phi = q by dense algebra. C follows from the charges for a unit
/// potential on one group and zero on all others.
Eigen::VectorXd by_dense_algebra(const LaplaceProblem& problem) {
  const auto n = static_cast<Eigen::Index>(problem.groups.size());
  CutCellSolver tight = solver(1e-12);
  const std::vector<double> c = capacitance_matrix(tight, problem);
  Eigen::MatrixXd matrix =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(c.data(), n, n);
  for (const auto& [a, b, capacitance] : problem.couplings) {
    matrix(a, a) += capacitance;
    matrix(b, b) += capacitance;
    matrix(a, b) -= capacitance;
    matrix(b, a) -= capacitance;
  }
  Eigen::VectorXd charge(n);
  for (Eigen::Index g = 0; g < n; ++g) {
    charge[g] = problem.groups[g].charge;
    if (problem.groups[g].floating) continue;
    charge[g] = problem.groups[g].potential * eps;
    matrix.row(g).setZero();
    matrix(g, g) = eps;
  }
  return solve_dense(matrix / eps, charge / eps);
}

void check_potentials(const LaplaceSolution& solution, const std::vector<double>& expected, double error) {
  REQUIRE(solution.group_potential.size() == expected.size());
  for (std::size_t g = 0; g < expected.size(); ++g) {
    CAPTURE(g);
    CHECK(std::abs(solution.group_potential[g] - expected[g]) < error);
  }
}

void check_potentials(const LaplaceSolution& solution, const Eigen::VectorXd& expected, double error) {
  check_potentials(solution, std::vector<double>(expected.begin(), expected.end()), error);
}

}  // namespace

TEST_CASE("NetworkFactors: links up to 1e200 keep the sum over the linked nodes") {
  // (1 + c) x - c y = 1 and (2 + c) y - c x = 5: the sum is x + 2 y = 6, and x = y = 2 up to 1 / c.
  for (const double c : {1e9, 1e15, 1e30, 1e200}) {
    double flow[] = {1, 5};
    NetworkFactors({1, 2}, {{0, 1, c}}).solve(flow);
    CHECK(flow[0] == doctest::Approx(2).epsilon(2 / c + 4e-16));
    CHECK(flow[0] + 2 * flow[1] == doctest::Approx(6).epsilon(4e-16));
  }
}

TEST_CASE("NetworkFactors::solve: satisfies Kirchhoff's law at 40 nodes") {
  Random random;
  constexpr int nodes = 40;
  std::vector<double> ground(nodes), flow(nodes);
  std::vector<NetworkLink> links;
  for (int k = 0; k < nodes; ++k) {
    ground[k] = k % 3 == 0 ? random(0, 1) : 0.0;
    flow[k] = random(-1, 1);
  }
  for (int k = 0; k < 3 * nodes; ++k) {
    const int a = random.index(nodes), b = random.index(nodes);
    if (a != b) links.push_back({a, b, random(0, 2)});
  }
  std::vector<double> potential = flow;
  NetworkFactors(ground, links).solve(potential.data());
  for (int k = 0; k < nodes; ++k) flow[k] -= ground[k] * potential[k];
  for (const auto& [a, b, conductance] : links) {
    flow[a] -= conductance * (potential[a] - potential[b]);
    flow[b] += conductance * (potential[a] - potential[b]);
  }
  // Rounding of about ten terms of up to 2 x 10 per node.
  for (const double left : flow) CHECK(std::abs(left) < 1e-13);
}

TEST_CASE("NetworkFactors: eliminating a star's centre gives the known triangle") {
  const NetworkFactors factors({0, 0, 0, 0}, {{0, 3, 1}, {3, 1, 2}, {2, 3, 5}}, {1, 1, 1, 0});
  for (const auto& [a, b, conductance] : factors.kept_links()) {
    const double arms[] = {1, 2, 5};
    CHECK(conductance == doctest::Approx(arms[a] * arms[b] / 8).epsilon(1e-15));
  }
  CHECK(factors.kept_links().size() == 3);
}

TEST_CASE("two disks joined by a lumped conductance: equal the bipolar solution") {
  // Two disks of radius R at distance d, one of them at 0 V. The walls have the exact potential in bipolar coordinates:
  // per charge q on the other, V = q acosh(d / 2R) / (pi eps). A coupling K to the fixed disk gives Q = q + K V.
  // Log-fitted links with R = 4 cells have an error of about 3e-4.
  const double R = 8, d = 24, side = 128;
  const Vec2 middle{64.3, 63.8}, e{std::cos(0.4), std::sin(0.4)};
  const double a = std::sqrt(0.25 * d * d - R * R), per_charge = std::acosh(0.5 * d / R) / pi;
  const Vec2 positive = middle - a * e, negative = middle + a * e;
  for (const double K : {1e-3, 0.3, 2.0, 1e4}) {
    const double Q = 3, q = Q / (1 + K * per_charge);
    LaplaceProblem problem{.permittivity = 1};
    problem.size = {side, side};
    for (Side& s : problem.sides) {
      s.kind = Side::Kind::electrode;
      s.profile = [=](Vec2 p) {
        return q * (std::log(norm(p - negative) / norm(p - positive)) / (2 * pi) + 0.5 * per_charge);
      };
    }
    problem.bodies = {{Disk{middle - 0.5 * d * e, R}, 0}, {Disk{middle + 0.5 * d * e, R}, 1}};
    problem.groups = {{.charge = Q}, {.floating = false}};
    problem.couplings = {{1, 0, K}};
    const LaplaceSolution solution = solver().solve(problem);
    CHECK(solution.group_potential[0] == doctest::Approx(q * per_charge).epsilon(3e-4).scale(0));
    CHECK(solution.body_charge[0] == doctest::Approx(q).epsilon(3e-4).scale(0));
  }
}

TEST_CASE("lumped conductances over twelve decades: solution equals dense algebra") {
  LaplaceProblem problem = random_disks(24);
  Random random;
  couple(problem, 0);
  for (Coupling& coupling : problem.couplings) coupling.capacitance = eps * std::pow(10, random(-6, 6));
  problem.groups.push_back({.floating = false, .potential = 2});
  problem.couplings.push_back({3, 25, 0.7 * eps});
  problem.couplings.push_back({3, 25, 0.4 * eps});
  problem.couplings.push_back({0, 7, 0.2 * eps});
  SUBCASE("next to a fixed body") {}
  SUBCASE("with a supply as the only ground") { problem.groups[0] = {.charge = 0.3 * eps}; }
  const LaplaceSolution solution = solve(problem);
  check_potentials(solution, by_dense_algebra(problem), uncertainty(solution));
  check_potentials(solve_assembled(problem), solution.group_potential, 2 * uncertainty(solution));
}

TEST_CASE("assembled matrix: equals multigrid for lumped conductances of any size") {
  for (const bool grounded : {true, false})
    for (const double K : {1e-12, 1e-3, 1.0, 900.0, 1100.0, 1e6, 1e12, 1e15}) {
      CAPTURE(grounded);
      CAPTURE(K);
      LaplaceProblem problem = grounded ? random_disks(24) : ungrounded(random_disks(24));
      couple(problem, K * eps);
      const LaplaceSolution solution = solve_assembled(problem), expected = solve(problem);
      check_potentials(solution, expected.group_potential, 2 * uncertainty(expected));
      const std::vector<double> charge = group_charges(problem, solution);
      double sum = 0;
      for (int g = 1; g <= 24; ++g) sum += charge[g] - problem.groups[g].charge;
      CHECK(std::abs(sum) < rounding_of_charges(problem, solution));
    }
}

TEST_CASE("lumped conductances: strong ones act as a wire, weak ones as none") {
  // The potential differences of a chain are at most (sum of |charges|) * (number of links) / K, and change all charges
  // and potentials accordingly. 24 disks with |charge| < eps store less than 24 eps.
  const auto compare = [](const LaplaceProblem& coupled, const LaplaceProblem& limit, double effect) {
    const LaplaceSolution solution = solve(coupled), expected = solve(limit);
    const double error = 2 * uncertainty(expected) + effect;
    for (std::size_t b = 0; b < coupled.bodies.size(); ++b) {
      CAPTURE(b);
      CHECK(std::abs(solution.group_potential[coupled.bodies[b].group] -
                     expected.group_potential[limit.bodies[b].group]) < error);
      // The capacitance of a disk to its surroundings is below 10 (2 pi R / smallest gap, over a part of the surface).
      CHECK(std::abs(solution.body_charge[b] - expected.body_charge[b]) < 10 * eps * error);
    }
  };
  const auto merge = [](LaplaceProblem problem) {
    for (std::size_t b = 1; b < problem.bodies.size(); ++b) problem.bodies[b].group = 1;
    for (std::size_t g = 2; g < problem.groups.size(); ++g) problem.groups[1].charge += problem.groups[g].charge;
    problem.groups.resize(2);
    problem.couplings.clear();
    return problem;
  };
  for (const bool grounded : {true, false}) {
    const LaplaceProblem alone = grounded ? random_disks(24) : ungrounded(random_disks(24));
    for (const double K : {1e9, 1e12, 1e15, 1e25}) {
      CAPTURE(K);
      LaplaceProblem problem = alone;
      couple(problem, K * eps, true);
      // Without ground both problems have the same mean potential of the bodies.
      compare(problem, merge(problem), 24 * 24 / K);
    }
    for (const double K : {1e-12, 1e-9, 0.0}) {
      CAPTURE(K);
      LaplaceProblem problem = alone;
      couple(problem, K * eps);
      compare(problem, alone, 24 * K * 2);  // 24 links with less than 2 V each.
    }
  }
}

TEST_CASE("lumped conductance to a source: sets the potentials of an insulated box") {
  LaplaceProblem problem = random_disks(9);
  problem.groups[0] = {};
  problem.groups.push_back({.floating = false, .potential = 7});
  double total = 0;
  for (const Group& group : problem.groups) total += group.charge;
  for (const double K : {1e-6, 1e-3, 1.0, 1e6, 1e12, 1e20}) {
    CAPTURE(K);
    problem.couplings = {{0, 10, K * eps}};
    const LaplaceSolution solution = solve(problem);
    // The supply is the only ground: it delivers the charge of the disks and the bar, whose own charge is 0.
    const double expected = 7 + total / (K * eps);
    // About 100 links round their potentials by 1e-16, and their sum is divided by K.
    CHECK(std::abs(solution.group_potential[0] - expected) < 1e-12 * std::abs(expected) / std::min(1.0, K));
  }
}

TEST_CASE("lumped conductances: nodes without bodies add in series and in parallel") {
  LaplaceProblem direct = random_disks(9), nodes = direct;
  direct.couplings = {{1, 2, 0.5 * eps}, {3, 4, 2 * eps}};
  direct.groups[5].charge += 0.25 * eps;
  direct.groups[6].charge += 0.75 * eps;
  nodes.groups.push_back({});  // 10: 1 and 1 in series are 0.5.
  nodes.groups.push_back({});  // 11, 12: 3 and (4 + 2) in series are 2, with a dead end.
  nodes.groups.push_back({});
  nodes.groups.push_back({.charge = 1.0 * eps});  // 13: its charge splits as 1 to 3.
  nodes.couplings = {{1, 10, eps},     {10, 2, eps},      {3, 11, 3 * eps}, {11, 4, 4 * eps},
                     {4, 11, 2 * eps}, {11, 12, 9 * eps}, {13, 5, 1e3},     {6, 13, 3e3}};
  // The couplings of 13 in series join 5 and 6, which `direct` also couples strongly.
  direct.couplings.push_back({5, 6, 750});
  const LaplaceSolution solution = solve(nodes), expected = solve(direct);
  const double error = 2 * uncertainty(expected);
  for (int g = 0; g < 10; ++g) CHECK(std::abs(solution.group_potential[g] - expected.group_potential[g]) < error);
  const std::vector<double>& phi = solution.group_potential;
  CHECK(phi[10] == doctest::Approx(0.5 * (phi[1] + phi[2])).epsilon(1e-14));
  CHECK(phi[11] == doctest::Approx((phi[3] + 2 * phi[4]) / 3).epsilon(1e-14));
  CHECK(phi[12] == doctest::Approx(phi[11]).epsilon(1e-14));
  CHECK(phi[13] == doctest::Approx(0.25 * (phi[5] + 3 * phi[6])).epsilon(1e-12));
}

TEST_CASE("lumped conductances: charge is conserved to rounding at tolerance 1e-3") {
  for (const double K : {1e-3, 1.0, 1e6, 1e12}) {
    CAPTURE(K);
    LaplaceProblem problem = random_disks(24);
    for (int disk = 1; disk < 12; ++disk) problem.couplings.push_back({disk, disk + 1, K * eps});
    problem.couplings.push_back({2, 9, 0.1 * K * eps});  // A loop.
    for (int disk = 13; disk < 24; ++disk) problem.couplings.push_back({13, disk + 1, K * eps});
    const LaplaceSolution solution = CutCellSolver({.cells = 64, .tolerance = 1e-3, .threads = 1}).solve(problem);
    const std::vector<double> charge = group_charges(problem, solution);
    double first = 0, second = 0, total = 0;
    for (int g = 1; g <= 24; ++g) (g <= 12 ? first : second) += charge[g] - problem.groups[g].charge;
    for (const double q : charge) total += q;
    // Rounding of 1000 links with conductances of 1 to 10 and a few volts, 1e-16 each.
    constexpr double rounding = 1e-12 * eps;
    CHECK(std::abs(first) < rounding);
    CHECK(std::abs(second) < rounding);
    CHECK(std::abs(total) < rounding);
    // The charge of each group, as precisely as currents follow from potentials rounded to 1e-16 of a few volts.
    std::vector<double> left = charge;
    for (const auto& [a, b, capacitance] : problem.couplings) {
      const double flow = capacitance * (solution.group_potential[a] - solution.group_potential[b]);
      left[a] += flow;
      left[b] -= flow;
    }
    for (int g = 1; g <= 24; ++g) CHECK(std::abs(left[g] - problem.groups[g].charge) < rounding + 1e-14 * K * eps);
  }
}

TEST_CASE("coupling_charges: balance each group's charge and obey Ohm's law") {
  for (const double K : {1e-12, 1e-3, 1.0, 1e6, 1e12, 1e20}) {
    CAPTURE(K);
    LaplaceProblem problem = random_disks(24);
    couple(problem, K * eps);
    problem.couplings.push_back({5, 17, 2 * K * eps});
    problem.groups.push_back({.floating = false, .potential = 1});
    problem.couplings.push_back({25, 3, K * eps});
    for (const bool assembled : {false, true}) {
      const LaplaceSolution solution = assembled ? solve_assembled(problem) : solve(problem);
      const std::vector<double> flowed = coupling_charges(problem, solution);
      std::vector<double> left = group_charges(problem, solution);
      for (std::size_t k = 0; k < flowed.size(); ++k) {
        const auto& [a, b, capacitance] = problem.couplings[k];
        left[a] += flowed[k];
        left[b] -= flowed[k];
        // Ohm's law within the rounding of potentials of a few volts.
        const double difference = solution.group_potential[a] - solution.group_potential[b];
        CHECK(std::abs(flowed[k] - capacitance * difference) < (1e-12 + 1e-14 * K) * eps);
      }
      for (int g = 1; g <= 24; ++g) CHECK(std::abs(left[g] - problem.groups[g].charge) < 1e-12 * eps);
    }
  }
}

TEST_CASE("lumped conductances: cost at most 6 more iterations at any strength") {
  // Coarse grids treat disks of 1 to 3 cells as a medium, or as subgrid conductors if their couplings exceed 0.05 eps.
  // Just above this limit a few more iterations are needed (docs/numerics/multigrid.md), over 27 decades and for any
  // ground.
  for (const int ground : {0, 1, 2})
    for (const bool chain : {true, false}) {
      LaplaceProblem problem = ground == 0 ? random_disks(60) : ungrounded(random_disks(60));
      if (ground == 2) problem.groups.push_back({.floating = false, .potential = 1});
      const int alone = solve(ground == 2 ? ungrounded(random_disks(60)) : problem).iterations;
      for (const double K : {1e-12, 1e-4, 0.03, 0.1, 0.3, 1.0, 3.0, 1e2, 1e4, 1e8, 1e12, 1e15}) {
        CAPTURE(ground);
        CAPTURE(K);
        problem.couplings.clear();
        if (ground == 2) problem.couplings.push_back({0, 61, K * eps});
        couple(problem, K * eps, chain);
        CHECK(solve(problem).iterations <= alone + 6);
      }
    }
}

TEST_CASE("solution history: new lumped conductances need no cold start") {
  LaplaceProblem problem = random_disks(24);
  CutCellSolver warm = solver();
  for (int step = 0; step < 3; ++step) warm.solve(problem);
  couple(problem, 1e12 * eps);
  const LaplaceSolution solution = warm.solve(problem), expected = solve(problem);
  check_potentials(solution, expected.group_potential, 2 * uncertainty(expected));
  CHECK(solution.iterations <= expected.iterations + 2);
  // A repeated problem needs no iteration.
  CHECK(warm.solve(problem).iterations <= 1);
}

TEST_CASE("lumped conductances: any number of threads gives identical bits") {
  LaplaceProblem problem = random_disks(40);
  couple(problem, eps);
  const LaplaceSolution one = solver(tolerance, 1).solve(problem), three = solver(tolerance, 3).solve(problem);
  CHECK(one.group_potential == three.group_potential);
  CHECK(one.body_charge == three.body_charge);
  CHECK(one.iterations == three.iterations);
}

TEST_CASE("grid of 63 cells without coarser grids: solves lumped conductances") {
  LaplaceProblem problem = random_disks(12);
  for (const double K : {1.0, 1e6, 1e12}) {
    problem.couplings.clear();
    couple(problem, K * eps, true);
    CutCellSolver odd({.cells = 63, .tolerance = tolerance, .threads = 1});
    const LaplaceSolution solution = odd.solve(problem);
    CHECK(solution.iterations <= 3);
    const std::vector<double> charge = group_charges(problem, solution);
    double sum = 0;
    for (int g = 1; g <= 12; ++g) sum += charge[g] - problem.groups[g].charge;
    CHECK(std::abs(sum) < 1e-12 * eps);  // Rounding.
  }
}

}  // namespace couplings_test
