#include "solvers/laplace/cutcell/solver.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <future>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/multigrid.hpp"
#include "solvers/laplace/cutcell/operator.hpp"
#include "solvers/laplace/cutcell/petsc.hpp"
#include "solvers/laplace/cutcell/results.hpp"
#include "solvers/laplace/cutcell/system.hpp"

namespace lichtenberg::laplace {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The stop criterion: CG's natural norm sqrt(r' M r) estimates the energy norm of the error, and it is compared with
/// the energy norm of the solution. The plain residual would be useless here: a short link (a cell centre that all
/// but touches a conductor) makes it as large as it likes.
struct StopCriterion {
  double tolerance = 0;
  double energy_norm = 0;  ///< of the first guess; what the first residual adds is part of the solution's as well
  double scale = 0, last = 0;
};

PetscErrorCode stop_test(KSP, PetscInt iteration, PetscReal norm, KSPConvergedReason* reason, void* context) {
  auto& criterion = *static_cast<StopCriterion*>(context);
  if (iteration == 0) criterion.scale = std::hypot(criterion.energy_norm, norm);
  criterion.last = criterion.scale > 0 ? norm / criterion.scale : 0.0;
  *reason = KSP_CONVERGED_ITERATING;
  if (!(std::isfinite(norm)))
    *reason = KSP_DIVERGED_NANORINF;
  else if (norm <= criterion.tolerance * criterion.scale)
    *reason = iteration == 0 ? KSP_CONVERGED_ATOL : KSP_CONVERGED_RTOL;
  return 0;
}

/// A KSP with its matrix and vectors, of either kind.
struct LinearSystem {
  KSP ksp = nullptr;
  Mat matrix = nullptr;
  Vec x = nullptr, b = nullptr;
  MatNullSpace null_space = nullptr;

  LinearSystem() = default;
  LinearSystem(const LinearSystem&) = delete;
  LinearSystem& operator=(const LinearSystem&) = delete;
  ~LinearSystem() { release(); }
  void release() {
    if (!petsc_started()) return;
    KSPDestroy(&ksp);
    MatDestroy(&matrix);
    VecDestroy(&x);
    VecDestroy(&b);
    MatNullSpaceDestroy(&null_space);
  }
};

}  // namespace

struct CutCellSolver::Implementation {
  explicit Implementation(CutCellOptions o) : options(o) {}

  CutCellOptions options;
  Vec2 size;  // of the box the grids were made for
  double smallest_radius = 0;
  std::unique_ptr<Level> level;
  std::unique_ptr<Multigrid> multigrid;
  CutCellOperator op;
  LinearSystem system;
  SparseSystem sparse;  // assembled only; the AIJ matrix borrows its arrays
  StopCriterion criterion;
  std::vector<double> b, x;  // layout + groups
  double scale = 1;          // V: x, b and the past are in units of it

  // First guesses: the last potentials, newest first, covered cells filled with their conductor's.
  struct Past {
    std::vector<double> cell, body;
  };
  std::deque<Past> history;
  static constexpr std::size_t history_length = 3;

  LaplaceSolution solve(const LaplaceProblem& problem);
  void choose_scale();
  void prepare_grids(const LaplaceProblem& problem);
  void discretize(const LaplaceProblem& problem);
  void prepare_system(const LaplaceProblem& problem);
  void make_matrix_free();
  void make_assembled();
  void set_defaults();
  void attach_null_space(const LaplaceProblem& problem);
  std::vector<double> on_unknowns(const LaplaceProblem& problem, const Past& past) const;
  double first_guess(const LaplaceProblem& problem);
  void run_krylov(LaplaceSolution& solution);
  void fix_mean(const LaplaceProblem& problem);
  void remember(const LaplaceProblem& problem, const LaplaceSolution& solution);
};

namespace {

PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  CutCellOperator* op = nullptr;
  PetscCall(MatShellGetContext(matrix, &op));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  op->apply(from, to);
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(VecRestoreArrayWrite(y, &to));
  return 0;
}

PetscErrorCode precondition(PC pc, Vec r, Vec z) {
  Multigrid* multigrid = nullptr;
  PetscCall(PCShellGetContext(pc, &multigrid));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(r, &from));
  PetscCall(VecGetArrayWrite(z, &to));
  multigrid->apply(from, to);
  PetscCall(VecRestoreArrayRead(r, &from));
  PetscCall(VecRestoreArrayWrite(z, &to));
  return 0;
}

}  // namespace

void CutCellSolver::Implementation::prepare_grids(const LaplaceProblem& problem) {
  double smallest = INFINITY;
  for (const Body& body : problem.bodies)
    if (const auto* disk = std::get_if<Disk>(&body.shape)) smallest = std::min(smallest, disk->radius);
  if (level && size == problem.size && smallest == smallest_radius) return;
  const double h = std::max(problem.size.x, problem.size.y) / options.cells;
  const int nx = static_cast<int>(std::lround(problem.size.x / h)),
            ny = static_cast<int>(std::lround(problem.size.y / h));
  if (options.cells < 4 || nx < 1 || ny < 1 || std::abs(nx * h - problem.size.x) > 1e-9 * problem.size.x ||
      std::abs(ny * h - problem.size.y) > 1e-9 * problem.size.y)
    throw InputError(
        "field.cells = " + std::to_string(options.cells) +
        ": the domain's shorter side must hold a whole number of square cells, and there must be at least 4");
  system.release();
  level = std::make_unique<Level>(problem, nx, ny);
  multigrid = std::make_unique<Multigrid>(options.links);
  history.clear();
  size = problem.size;
  smallest_radius = smallest;
}

/// Links and levels. The coarser grids know nothing of the finest: they are made beside it, on another core if there is
/// one.
void CutCellSolver::Implementation::discretize(const LaplaceProblem& problem) {
  const bool matrix_free = options.linear_solver == CutCellOptions::LinearSolver::multigrid;
  std::future<void> coarser;
  if (matrix_free) {
    multigrid->prepare(problem, level->layout);
    const auto policy = std::thread::hardware_concurrency() > 1 ? std::launch::async : std::launch::deferred;
    coarser = std::async(policy, [&] { multigrid->build_coarse(problem); });
  }
  level->build(problem, options.links);
  op.build(problem, *level);
  if (matrix_free) {
    multigrid->build_finest(problem, *level);
    coarser.get();
  }
}

void CutCellSolver::Implementation::prepare_system(const LaplaceProblem& problem) {
  x.resize(op.size());
  b.resize(op.size());
  if (options.linear_solver == CutCellOptions::LinearSolver::multigrid) {
    make_matrix_free();
  } else {
    system.release();
    sparse = assemble(problem, *level, false, false);
    make_assembled();
  }
  attach_null_space(problem);
  check_petsc(KSPSetUp(system.ksp));
}

void CutCellSolver::Implementation::make_matrix_free() {
  const auto n = static_cast<PetscInt>(op.size());
  PetscInt have = -1;
  if (system.x) check_petsc(VecGetSize(system.x, &have));
  if (have != n) {
    system.release();
    check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, nullptr, &system.x));
    check_petsc(VecDuplicate(system.x, &system.b));
    check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &op, &system.matrix));
    check_petsc(MatShellSetOperation(system.matrix, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
    check_petsc(KSPCreate(PETSC_COMM_SELF, &system.ksp));
    PC pc = nullptr;
    check_petsc(KSPGetPC(system.ksp, &pc));
    check_petsc(PCSetType(pc, PCSHELL));
    check_petsc(PCShellSetApply(pc, precondition));
    check_petsc(PCShellSetContext(pc, multigrid.get()));
    check_petsc(PCShellSetName(pc, "cut-cell multigrid"));
    set_defaults();
    PCType type = nullptr;
    check_petsc(PCGetType(pc, &type));
    if (const std::string chosen = type; chosen != PCSHELL && chosen != PCNONE) {
      system.release();
      throw InputError(
          "-field_pc_type " + chosen +
          " needs a matrix: set field.linear_solver = \"assembled\" in the scene, or leave the option out");
    }
  }
  check_petsc(KSPSetOperators(system.ksp, system.matrix, system.matrix));
}

void CutCellSolver::Implementation::make_assembled() {
  const auto n = static_cast<PetscInt>(sparse.unknowns());
  check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, sparse.start.data(), sparse.index.data(),
                                        sparse.value.data(), &system.matrix));
  check_petsc(MatSetOption(system.matrix, MAT_SPD, PETSC_TRUE));
  check_petsc(MatCreateVecs(system.matrix, &system.x, &system.b));
  check_petsc(KSPCreate(PETSC_COMM_SELF, &system.ksp));
  PC pc = nullptr;
  check_petsc(KSPGetPC(system.ksp, &pc));
  check_petsc(PCSetType(pc, PCGAMG));
  set_defaults();
  check_petsc(KSPSetOperators(system.ksp, system.matrix, system.matrix));
}

void CutCellSolver::Implementation::set_defaults() {
  check_petsc(KSPSetOptionsPrefix(system.ksp, "field_"));
  check_petsc(KSPSetType(system.ksp, KSPCG));
  check_petsc(KSPSetNormType(system.ksp, KSP_NORM_NATURAL));
  check_petsc(KSPSetTolerances(system.ksp, options.tolerance, PETSC_DEFAULT, PETSC_DEFAULT, 500));
  check_petsc(KSPSetInitialGuessNonzero(system.ksp, PETSC_TRUE));
  check_petsc(KSPSetConvergenceTest(system.ksp, stop_test, &criterion, nullptr));
  check_petsc(KSPSetFromOptions(system.ksp));
}

/// Nothing grounded: potentials are defined up to a constant. The null vector is 1 on every unknown; in the
/// matrix-free layout padding and covered cells are no unknowns.
void CutCellSolver::Implementation::attach_null_space(const LaplaceProblem& problem) {
  check_petsc(MatNullSpaceDestroy(&system.null_space));
  if (problem.has_ground()) {
    check_petsc(MatSetNullSpace(system.matrix, nullptr));
    return;
  }
  if (options.linear_solver == CutCellOptions::LinearSolver::assembled) {
    check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_TRUE, 0, nullptr, &system.null_space));
  } else {
    Vec ones = nullptr;
    check_petsc(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(op.size()), &ones));
    PetscScalar* value = nullptr;
    check_petsc(VecGetArrayWrite(ones, &value));
    const std::size_t cells = level->layout.size();
    for (std::size_t k = 0; k < cells; ++k) value[k] = level->diagonal[k] > 0 ? 1.0 : 0.0;
    std::fill(value + cells, value + op.size(), 1.0);
    check_petsc(VecRestoreArrayWrite(ones, &value));
    check_petsc(VecNormalize(ones, nullptr));
    check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &system.null_space));
    check_petsc(VecDestroy(&ones));
  }
  check_petsc(MatSetNullSpace(system.matrix, system.null_space));
}

/// Past potentials as a vector of the present geometry: uncovered cells have their conductor's last potential, a new
/// group the mean of its members'.
std::vector<double> CutCellSolver::Implementation::on_unknowns(const LaplaceProblem& problem, const Past& past) const {
  const std::size_t cells = level->layout.size();
  std::vector<double> v(op.size(), 0.0);
  std::copy(past.cell.begin(), past.cell.end(), v.begin());
  std::vector<int> members(problem.groups.size(), 0);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    v[cells + problem.bodies[body].group] += past.body[body];
    ++members[problem.bodies[body].group];
  }
  for (std::size_t g = 0; g < members.size(); ++g)
    if (members[g] > 0) v[cells + g] /= members[g];
  op.mask(v.data());
  return v;
}

/// The combination of the last solutions that is closest to the new one in the energy norm (a Galerkin projection with
/// the new operator; Fischer 1998). For a scene in motion that is extrapolation in time, whatever the steps were.
/// Returns the guess's energy norm.
double CutCellSolver::Implementation::first_guess(const LaplaceProblem& problem) {
  std::fill(x.begin(), x.end(), 0.0);
  if (history.empty()) return 0.0;
  const std::size_t n = op.size();
  const auto m = static_cast<Eigen::Index>(history.size());
  // The newest solution and successive differences: nearly orthogonal where the solutions are nearly parallel.
  std::vector<std::vector<double>> basis, image;
  for (std::size_t p = 0; p < history.size(); ++p) {
    basis.push_back(on_unknowns(problem, history[p == 0 ? 0 : p - 1]));
    if (p > 0) {
      const std::vector<double> older = on_unknowns(problem, history[p]);
      for (std::size_t k = 0; k < n; ++k) basis[p][k] -= older[k];
    }
    image.emplace_back(n);
    op.apply(basis[p].data(), image[p].data());
  }
  const auto as_vector = [n](const std::vector<double>& v) {
    return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(n));
  };
  Eigen::MatrixXd gram(m, m);
  Eigen::VectorXd projection(m);
  for (Eigen::Index p = 0; p < m; ++p) {
    for (Eigen::Index q = 0; q <= p; ++q) gram(p, q) = gram(q, p) = as_vector(basis[p]).dot(as_vector(image[q]));
    projection(p) = as_vector(basis[p]).dot(as_vector(b));
  }
  // Scaled to unit diagonal, a direction that is all but dependent on the others is left out by the pivoting.
  const Eigen::VectorXd unit = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * gram * unit.asDiagonal();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-10);
  solver.compute(scaled);
  const Eigen::VectorXd alpha = unit.cwiseProduct(solver.solve(unit.cwiseProduct(projection)));
  Eigen::Map<Eigen::VectorXd> guess(x.data(), static_cast<Eigen::Index>(n));
  for (Eigen::Index p = 0; p < m; ++p) guess += alpha(p) * as_vector(basis[p]);
  return std::sqrt(std::max(0.0, alpha.dot(projection)));
}

void CutCellSolver::Implementation::run_krylov(LaplaceSolution& solution) {
  const bool matrix_free = options.linear_solver == CutCellOptions::LinearSolver::multigrid;
  if (matrix_free) {
    check_petsc(VecPlaceArray(system.x, x.data()));
    check_petsc(VecPlaceArray(system.b, b.data()));
  } else {
    const auto copy = [&](const std::vector<double>& from, Vec to) {
      PetscScalar* value = nullptr;
      check_petsc(VecGetArrayWrite(to, &value));
      for (std::size_t a = 0; a < sparse.slot.size(); ++a) value[a] = from[sparse.slot[a]];
      for (std::size_t g = 0; g < sparse.group.size(); ++g)
        value[sparse.slot.size() + g] = from[level->layout.size() + sparse.group[g]];
      check_petsc(VecRestoreArrayWrite(to, &value));
    };
    copy(x, system.x);
    copy(b, system.b);
  }
  check_petsc(KSPSolve(system.ksp, system.b, system.x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check_petsc(KSPGetConvergedReason(system.ksp, &reason));
  check_petsc(KSPGetIterationNumber(system.ksp, &iterations));
  if (matrix_free) {
    check_petsc(VecResetArray(system.x));
    check_petsc(VecResetArray(system.b));
  } else {
    const PetscScalar* value = nullptr;
    check_petsc(VecGetArrayRead(system.x, &value));
    for (std::size_t a = 0; a < sparse.slot.size(); ++a) x[sparse.slot[a]] = value[a];
    for (std::size_t g = 0; g < sparse.group.size(); ++g)
      x[level->layout.size() + sparse.group[g]] = value[sparse.slot.size() + g];
    check_petsc(VecRestoreArrayRead(system.x, &value));
  }
  if (reason < 0)
    throw Failure(std::string("field solver: no convergence after ") + std::to_string(iterations) + " iterations (" +
                  KSPConvergedReasons[reason] + ", relative error estimate " + std::to_string(criterion.last) +
                  "); a larger field.tolerance may be all that rounding allows");
  solution.iterations = static_cast<int>(iterations);
  solution.residual = criterion.last;
}

void CutCellSolver::Implementation::fix_mean(const LaplaceProblem& problem) {
  double mean = 0;
  for (const Body& body : problem.bodies) mean += x[level->layout.size() + body.group];
  mean /= static_cast<double>(std::max<std::size_t>(problem.bodies.size(), 1));
  // Unknowns only: the padding must stay zero, this solution is a first guess of the next.
  const std::size_t cells = level->layout.size();
  for (std::size_t k = 0; k < cells; ++k)
    if (level->diagonal[k] > 0) x[k] -= mean;
  for (std::size_t k = cells; k < x.size(); ++k) x[k] -= mean;
  op.mask(x.data());
}

void CutCellSolver::Implementation::remember(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  Past past;
  if (history.size() == history_length) {
    past = std::move(history.back());
    history.pop_back();
  }
  past.cell.assign(x.begin(), x.begin() + level->layout.size());
  past.body.resize(problem.bodies.size());
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    past.body[body] = solution.group_potential[problem.bodies[body].group] / scale;
  for (const std::ptrdiff_t slot : level->covered) past.cell[slot] = past.body[level->cover[slot]];
  history.push_front(std::move(past));
}

/// Single precision holds 38 decades either way: enough for any right-hand side of about 1. The scale is kept while it
/// is good enough, so that past solutions need no rescaling.
void CutCellSolver::Implementation::choose_scale() {
  double largest = 0;
  for (const double value : b) largest = std::max(largest, std::abs(value));
  const double ratio = largest / scale;
  if (!history.empty() && (largest == 0 || (ratio > 1e-6 && ratio < 1e6))) return;
  history.clear();
  scale = largest > 0 ? largest : 1;
}

LaplaceSolution CutCellSolver::Implementation::solve(const LaplaceProblem& problem) {
  problem.check();
  start_petsc();
  LaplaceSolution solution;
  auto start = std::chrono::steady_clock::now();
  prepare_grids(problem);
  if (!history.empty() && history.front().body.size() != problem.bodies.size()) history.clear();
  discretize(problem);
  prepare_system(problem);
  solution.seconds.setup = seconds_since(start);

  start = std::chrono::steady_clock::now();
  op.right_hand_side(problem, b.data());
  choose_scale();
  for (double& value : b) value /= scale;
  criterion = {options.tolerance, first_guess(problem), 0, 0};
  run_krylov(solution);
  op.balance_groups(b.data(), x.data());
  if (!problem.has_ground()) fix_mean(problem);
  solution.seconds.solve = seconds_since(start);

  start = std::chrono::steady_clock::now();
  solution.unknowns = level->fluid_cells;
  for (const Group& group : problem.groups) solution.unknowns += group.floating;
  solution.group_potential.resize(problem.groups.size());
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    solution.group_potential[g] =
        problem.groups[g].floating ? scale * x[level->layout.size() + g] : problem.groups[g].potential;
  evaluate(problem, *level, x.data(), scale, solution);
  remember(problem, solution);
  solution.seconds.forces = seconds_since(start);
  return solution;
}

CutCellSolver::CutCellSolver(CutCellOptions options) : implementation_(std::make_unique<Implementation>(options)) {}
CutCellSolver::~CutCellSolver() = default;

LaplaceSolution CutCellSolver::solve(const LaplaceProblem& problem) { return implementation_->solve(problem); }
void CutCellSolver::forget() { implementation_->history.clear(); }
void CutCellSolver::set_tolerance(double tolerance) { implementation_->options.tolerance = tolerance; }

Field CutCellSolver::field() const {
  const Implementation& s = *implementation_;
  if (s.history.empty()) throw Failure("field solver: no field before the first solve");
  const Level& level = *s.level;
  Field field{level.layout.nx, level.layout.ny, level.h, {}, {}};
  for (int j = 0; j < field.ny; ++j)
    for (int i = 0; i < field.nx; ++i) {
      field.value.push_back(s.scale * s.history.front().cell[level.layout(i, j)]);
      field.body.push_back(level.cover[level.layout(i, j)]);
    }
  return field;
}

}  // namespace lichtenberg::laplace
