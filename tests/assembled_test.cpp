// Tests of the assembled system on one process, and on all processes that mpirun starts: `mpirun -n 2 assembled_test`.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "tests/cutcell_problems.hpp"

namespace assembled_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr double tolerance = 1e-10;

/// Potentials have the tolerance in the energy norm relative to the solution's norm. In a box of a few radii with a few
/// groups the largest group potential is of the order of this norm. A factor of 100 covers the constants.
constexpr double agreement = 100 * tolerance;

/// Twelve disks, some with a common potential, around a grounded half-disk; without it there is no ground.
LaplaceProblem random_disks(bool grounded) {
  random_placement::Random random(3);
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {96, 64};
  if (grounded) {
    problem.bodies = {{Disk{{48, 0}, 10}, 0}};
    problem.groups = {{false, 0, 0}};
  }
  while (problem.bodies.size() < 12) {
    const Disk disk{{random(6, 90), random(6, 58)}, 5};
    random_placement::add_if_free(problem, disk, 0.2, random);
  }
  problem.bodies.back().group = static_cast<int>(problem.groups.size()) - 2;  // Two disks with one potential.
  problem.groups.pop_back();
  if (!grounded) {
    double sum = 0;
    for (const Group& group : problem.groups) sum += group.charge;
    problem.groups[0].charge -= sum;
  }
  return problem;
}

CutCellOptions options(CutCellOptions::LinearSolver linear_solver) {
  return {.cells = 96, .tolerance = tolerance, .linear_solver = linear_solver};
}

void check_same(const LaplaceSolution& a, const LaplaceSolution& b) {
  double potential = 0, charge = 0, force = 0;
  for (const double phi : a.group_potential) potential = std::max(potential, std::abs(phi));
  for (const double q : a.body_charge) charge = std::max(charge, std::abs(q));
  for (const Vec2 f : a.body_force) force = std::max(force, norm(f));
  for (std::size_t g = 0; g < a.group_potential.size(); ++g)
    CHECK(std::abs(a.group_potential[g] - b.group_potential[g]) < agreement * potential);
  for (std::size_t k = 0; k < a.body_charge.size(); ++k) {
    CHECK(std::abs(a.body_charge[k] - b.body_charge[k]) < agreement * charge);
    // Through the shortest link, 1 / gap = 5 cells, squared.
    CHECK(norm(a.body_force[k] - b.body_force[k]) < 25 * agreement * force);
  }
}

/// Gathers the value of each process in the first process.
std::vector<double> all_of(double value) {
  std::vector<double> values(parallel::process_count());
  MPI_Gather(&value, 1, MPI_DOUBLE, values.data(), 1, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  return values;
}

}  // namespace

TEST_CASE("assembled matrix: solutions equal matrix-free ones, also after motion") {
  for (const auto& [grounded, coupling] :
       {std::pair{true, 0.0}, {false, 0.0}, {true, 0.5}, {true, 1e9}, {false, 1e9}}) {
    CAPTURE(grounded);
    CAPTURE(coupling);
    LaplaceProblem problem = random_disks(grounded);
    problem.couplings = {{2, 3, coupling}, {3, 6, coupling}};
    CutCellSolver matrix_free(options(CutCellOptions::LinearSolver::multigrid));
    CutCellSolver assembled(options(CutCellOptions::LinearSolver::assembled));
    for (int step = 0; step < 3; ++step) {
      const LaplaceSolution a = matrix_free.solve(problem), b = assembled.solve(problem);
      check_same(a, b);
      CHECK(a.unknowns == b.unknowns);
      CHECK(a.work > 0);
      CHECK(b.work == 0);  // Not counted, because PETSc's preconditioners do not report it.
      for (Body& body : problem.bodies) std::get<Disk>(body.shape).centre += Vec2{0.02, 0.01};
    }
  }
}

TEST_CASE("assembled matrix: all processes get bitwise identical solutions") {
  CutCellSolver solver(options(CutCellOptions::LinearSolver::assembled));
  const LaplaceSolution solution = solver.solve(random_disks(true));
  double sum = 0;
  for (const double v : solver.field().value) sum += v;
  for (const double value : {solution.energy, solution.group_potential[3], solution.body_force[5].x, sum}) {
    const std::vector<double> values = all_of(value);
    if (parallel::process_rank() == 0)
      for (const double other : values) CHECK(other == values[0]);
  }
}

TEST_CASE("assembled matrix with 13 unknowns: neutral disk has the electrode's 1 V") {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {4, 4};
  problem.sides[left] = {Side::Kind::electrode, 1, {}};
  problem.bodies = {{Disk{{2, 2}, 1.5}, 0}};
  problem.groups = {{true, 0, 0}};
  CutCellOptions o = options(CutCellOptions::LinearSolver::assembled);
  o.cells = 4;
  CutCellSolver solver(o);
  // Without charges the potential is the electrode's.
  CHECK(solver.solve(problem).group_potential[0] == doctest::Approx(1).epsilon(agreement));
}

TEST_CASE("-field_ksp_rtol: this option of PETSc overrides the solver's tolerance") {
  lichtenberg::parallel::start_petsc();
  CutCellSolver strict(options(CutCellOptions::LinearSolver::assembled));
  const int iterations = strict.solve(random_disks(true)).iterations;
  parallel::check_petsc(PetscOptionsSetValue(nullptr, "-field_ksp_rtol", "1e-3"));
  CutCellSolver loose(options(CutCellOptions::LinearSolver::assembled));
  const LaplaceSolution solution = loose.solve(random_disks(true));
  parallel::check_petsc(PetscOptionsClearValue(nullptr, "-field_ksp_rtol"));
  CHECK(solution.iterations < iterations);
  CHECK(solution.residual < 1e-3);
  CHECK(solution.residual > tolerance);
}

namespace {

/// Sets options of PETSc during its lifetime.
struct ChosenOptions {
  std::vector<std::array<const char*, 2>> list;
  explicit ChosenOptions(std::vector<std::array<const char*, 2>> options) : list(std::move(options)) {
    parallel::start_petsc();
    for (const auto& [name, value] : list) parallel::check_petsc(PetscOptionsSetValue(nullptr, name, value));
  }
  ChosenOptions(const ChosenOptions&) = delete;
  ~ChosenOptions() {
    for (const auto& option : list) PetscOptionsClearValue(nullptr, option[0]);
  }
};

/// Solves from zero, and from the first solution after all disks have moved.
std::array<LaplaceSolution, 2> two_solves(bool grounded) {
  CutCellSolver solver(options(CutCellOptions::LinearSolver::assembled));
  LaplaceProblem problem = random_disks(grounded);
  const LaplaceSolution first = solver.solve(problem);
  for (Body& body : problem.bodies) std::get<Disk>(body.shape).centre += Vec2{0.02, 0.01};
  return {first, solver.solve(problem)};
}

}  // namespace

TEST_CASE("PETSc's other linear solvers: give the solution of conjugate gradients") {
  constexpr const char *method = "-field_ksp_type", *preconditioner = "-field_pc_type";
  std::vector<std::vector<std::array<const char*, 2>>> choices = {
      {{method, "gmres"}},
      {{method, "fgmres"}},
      {{method, "minres"}},
      {{method, "bcgs"}},
      {{method, "tfqmr"}},
      {{method, "gcr"}, {"-field_ksp_norm_type", "unpreconditioned"}},
      {{method, "cg"}, {"-field_ksp_norm_type", "none"}}};
  if (parallel::process_count() == 1) {  // PETSc's own factorizations support one process only.
    choices.push_back({{method, "preonly"}, {preconditioner, "lu"}});
    choices.push_back({{method, "preonly"}, {preconditioner, "cholesky"}});
    choices.push_back({{method, "gmres"}, {preconditioner, "lu"}});
  }
  for (const bool grounded : {true, false}) {
    const auto expected = two_solves(grounded);
    for (const auto& choice : choices) {
      CAPTURE(grounded);
      CAPTURE(std::string(choice[0][1]));
      const ChosenOptions chosen(choice);
      const auto found = two_solves(grounded);
      for (int k = 0; k < 2; ++k) {
        check_same(expected[k], found[k]);
        CHECK(found[k].residual < tolerance);
      }
    }
  }
}

TEST_CASE("PETSc: a solver that stops before the tolerance is met throws Failure") {
  for (const auto& choice : std::vector<std::vector<std::array<const char*, 2>>>{
           {{"-field_ksp_type", "preonly"}},  // One V-cycle.
           {{"-field_ksp_norm_type", "none"}, {"-field_ksp_max_it", "3"}}}) {
    const ChosenOptions chosen(choice);
    CHECK_THROWS_AS(two_solves(true), Failure);
  }
}

TEST_CASE("LinkFormula::aperture: capacitance of first order, forces not convergent") {
  const double phi = std::acosh(2.0) / std::numbers::pi;
  std::array<double, 3> capacitance{}, force{};
  for (int level = 0; level < 3; ++level) {
    const double R = 4 << level;
    const int side = static_cast<int>(10 * R);
    CutCellOptions o = options(CutCellOptions::LinearSolver::assembled);
    o.cells = side;
    o.links = LinkFormula::aperture;
    CutCellSolver solver(o);
    for (int k = 0; k < 5; ++k) {
      const Vec2 middle{0.5 * side + 0.37 * k, 0.5 * side + 0.61 * k}, e{std::cos(k), std::sin(k)};
      const LaplaceSolution solution = solver.solve(cutcell_problems::two_disks(side, middle, e, R, 4 * R));
      const double exact = 1 / (4 * std::numbers::pi * std::sqrt(3.0) * R);
      capacitance[level] += std::abs(phi / solution.group_potential[0] - 1) / 5;
      force[level] += norm(solution.body_force[0] - exact * e) / exact / 5;
      double charge = 0;
      for (const double q : solution.body_charge) charge += q;
      for (const double q : solution.side_charge) charge += q;
      CHECK(std::abs(charge) < 1e-7);  // The balances of the cells, within the solver's tolerance.
    }
  }
  // The positions on the grid depend on R: the order is 1 within this scatter.
  const double order = 0.5 * std::log2(capacitance[0] / capacitance[2]);
  CHECK(order > 0.7);
  CHECK(order < 1.4);
  // Regression value: the relative error of the normal derivative in each cell does not depend on the grid. The same
  // holds for the sum of its squares.
  for (const double error : force) CHECK(error < 0.15);
  // The error of the distance from a centre to the surface is at most a quarter of a cell. It is relative to R ln 4,
  // over which the potential decreases.
  CHECK(capacitance[1] < 0.25 / (8 * std::log(4.0)));
}

TEST_CASE("LinkFormula::aperture: needs the assembled matrix and round bodies") {
  CutCellOptions o = options(CutCellOptions::LinearSolver::multigrid);
  o.links = LinkFormula::aperture;
  CHECK_THROWS_AS(CutCellSolver{o}, InputError);
  o.linear_solver = CutCellOptions::LinearSolver::assembled;
  LaplaceProblem problem = random_disks(true);
  problem.bodies.push_back({Bar{{1, 1}, {1, 9}, 1}, 0});
  CutCellSolver solver(o);
  CHECK_THROWS_AS(solver.solve(problem), InputError);
}

TEST_CASE("LinkFormula::aperture: tiny, grouped and cut disks have total charge 0") {
  CutCellOptions o = options(CutCellOptions::LinearSolver::assembled);
  o.links = LinkFormula::aperture;
  LaplaceProblem problem = random_disks(true);
  problem.bodies.push_back({Ring{{48, 32}, 60}, 0});
  problem.bodies.push_back({Disk{{3.3, 3.4}, 0.2}, static_cast<int>(problem.groups.size())});
  problem.groups.push_back({true, 0.1, 0});
  problem.sides[left] = {Side::Kind::electrode, 0, {}};
  CutCellSolver solver(o);
  const LaplaceSolution solution = solver.solve(problem);
  double charge = 0;
  for (const double q : solution.body_charge) charge += q;
  for (const double q : solution.side_charge) charge += q;
  CHECK(std::abs(charge) < 1e-7);
  // An initial guess from history accounts for closed faces.
  for (std::size_t k = 1; k < problem.bodies.size(); ++k)
    if (auto* disk = std::get_if<Disk>(&problem.bodies[k].shape)) disk->centre += Vec2{0.004, 0.003};
  const int warm = solver.solve(problem).iterations;
  solver.forget();
  CHECK(warm < solver.solve(problem).iterations);
}

}  // namespace assembled_test

int main(int argc, char** argv) {
  lichtenberg::parallel::start_petsc();
  return doctest::Context(argc, argv).run();
}
