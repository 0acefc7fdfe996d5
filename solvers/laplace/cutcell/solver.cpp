#include "solvers/laplace/cutcell/solver.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/laplace/circuit.hpp"
#include "solvers/laplace/cutcell/assembled.hpp"
#include "solvers/laplace/cutcell/backend.hpp"
#include "solvers/laplace/cutcell/body_order.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/follow.hpp"
#include "solvers/laplace/cutcell/history.hpp"
#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/laplace/cutcell/matrix_free.hpp"
#include "solvers/laplace/cutcell/results.hpp"
#include "solvers/laplace/cutcell/shares.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace {

namespace {

/// Returns the number of threads: by default at most the number of bands of loops over the finest grid. The assembled
/// system gets one, because PETSc runs it.
int team_size(const CutCellOptions& options) {
  if (options.linear_solver == CutCellOptions::LinearSolver::assembled) return 1;
  if (options.threads > 0) return options.threads;
  if (parallel::process_count() > 1) return 1;
  const long useful = static_cast<long>(options.cells) * options.cells / cells_a_band;
  const long available = std::max(1u, std::thread::hardware_concurrency());
  return static_cast<int>(std::clamp(useful, 1L, available));
}

/// Waits for a system's worker thread at the end of a solve, also if an exception is thrown, because the thread reads
/// the problem.
class FinishGuard {
 public:
  explicit FinishGuard(const std::unique_ptr<LinearSystem>& system) : system_(system) {}
  FinishGuard(const FinishGuard&) = delete;
  FinishGuard& operator=(const FinishGuard&) = delete;
  ~FinishGuard() {
    try {
      if (system_) system_->finish();
    } catch (...) {
      // The original exception is already propagating.
    }
  }

 private:
  const std::unique_ptr<LinearSystem>& system_;
};

/// Cut-cell solver on the CPU.
class CpuSolver : public CutCellBackend {
 public:
  explicit CpuSolver(const CutCellOptions& options) : CutCellBackend(options) {
    static int solvers = 0;
    number = solvers++;
  }
  ~CpuSolver() override { announce_end(number); }

  LaplaceSolution solve(const LaplaceProblem& problem) override {
    announce_solve(number, options_, problem);
    const FinishGuard guard(system);
    return CutCellBackend::solve(problem);
  }
  void forget() override {
    announce_forgetting(number);
    CutCellBackend::forget();
  }
  void follow(const CutCellBackend& coarser) override {
    followed = dynamic_cast<const CpuSolver*>(&coarser);
    if (followed) announce_following(number, options_, followed->number, followed->options_);
  }

 protected:
  void make_grids(const LaplaceProblem& problem) override;
  void discretize(const LaplaceProblem& problem) override;
  void begin(const LaplaceProblem& problem, LaplaceSolution& solution) override;
  void iterate(LaplaceSolution& solution) override;
  void finish(const LaplaceProblem& problem, LaplaceSolution& solution) override;
  bool has_history() const override { return !history.empty(); }
  void clear_history() override { history.clear(); }
  Field last_field() const override;

 private:
  bool assembled() const { return options_.linear_solver == CutCellOptions::LinearSolver::assembled; }
  double rounding_of_residual() const;
  void fix_mean();
  Potentials potentials() const;
  void store(const LaplaceProblem& problem, const LaplaceSolution& solution);

  int number;  // among the solvers of this program, known to its other processes
  parallel::Team team{team_size(options_)};
  BodyOrder order;
  std::unique_ptr<Level> level;
  CutCellOperator op;
  std::unique_ptr<LinearSystem> system;
  std::vector<double> b, x, residual;   // layout + groups
  SolutionHistory history;              // bodies' potentials in the order of the problems
  const CpuSolver* followed = nullptr;  // the solver on a coarser grid
  Potentials followed_then;             // its solution at the last solve here; no bodies: none
};

std::unique_ptr<LinearSystem> make_system(const CutCellOptions& options, parallel::Team& team) {
  if (options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    return std::make_unique<MatrixFreeSystem>(options.links, options.tolerance, team);
  return std::make_unique<AssembledSystem>(options.links, options.tolerance, options.device);
}

void CpuSolver::make_grids(const LaplaceProblem& problem) {
  const int processes = assembled() ? 1 : parallel::process_count();
  level = std::make_unique<Level>(
      problem, grid_layouts(finest_.nx, finest_.ny, assembled() ? 0 : parallel::process_rank(), processes).front());
  system = make_system(options_, team);
}

void CpuSolver::discretize(const LaplaceProblem& problem) {
  order.sort(problem, level->layout.ny);
  system->build(order.sorted(), *level, op);
  for (std::vector<double>* vector : {&x, &b, &residual}) parallel::resize_in_huge_pages(*vector, op.size());
}

void CpuSolver::begin(const LaplaceProblem& problem, LaplaceSolution& solution) {
  op.right_hand_side(order.sorted(), b.data(), unit_);
  const std::size_t bodies = problem.bodies.size();
  if (history.empty()) {
    system->finish();
    system->first_guess(order.sorted(), unit_, x);
  } else if (followed && !followed->history.empty() && followed->history.bodies() == bodies &&
             followed_then.body.size() == bodies) {
    history.newest_as_guess(problem, op, x);
    add_change(followed_then, followed->potentials(), problem, unit_, op, x);
  } else {
    solution.work += history.initial_guess(problem, op, b, x);
  }
}

void CpuSolver::iterate(LaplaceSolution& solution) {
  solution.work += op.relax_edges(b.data(), x.data(), edge_sweeps);
  const double guess_norm = op.stretch(b.data(), x.data(), residual.data());
  solution.work += 1;
  if (op.grounded_by_couplings()) op.fix_potential_level(x.data(), residual.data());
  system->finish();
  system->solve(b, x, residual, {options_.tolerance, guess_norm, 0, 0, rounding_of_residual()}, solution);
  op.balance(order.sorted(), unit_, b.data(), x.data());
  if (!order.sorted().has_ground()) fix_mean();
}

/// Returns the natural norm of the residual that rounding leaves. A row adds some five potentials of at most |x|. This
/// leaves a residual of about epsilon |x|, random from row to row. The natural norm squared is the sum of its square
/// over the Laplacian's eigenvalues, 4 pi k / n of the k-th of n modes. The result is epsilon^2 x^2 n (log n) / 4 pi,
/// in which log n / 4 pi is about 1.
double CpuSolver::rounding_of_residual() const {
  const Layout& at = level->layout;
  const std::size_t unknowns = Layout(at.nx, at.ny).size() + x.size() - op.cells();
  const Eigen::Map<const Eigen::VectorXd> all(x.data(), static_cast<Eigen::Index>(x.size()));
  return std::numeric_limits<double>::epsilon() * std::sqrt(static_cast<double>(unknowns)) *
         largest_of_slabs(at, all.lpNorm<Eigen::Infinity>());
}

void CpuSolver::fix_mean() {
  const std::vector<Body>& bodies = order.sorted().bodies;
  double mean = 0;
  for (const Body& body : bodies) mean += x[level->layout.size() + body.group];
  mean /= static_cast<double>(std::max<std::size_t>(bodies.size(), 1));
  // Shifts unknowns only. The padding must stay zero, because the solution becomes part of the history.
  const std::size_t cells = level->layout.size();
  for (std::size_t k = 0; k < cells; ++k)
    if (level->diagonal[k] > 0) x[k] -= mean;
  for (std::size_t k = cells; k < x.size(); ++k) x[k] -= mean;
  op.mask(x.data());
}

void CpuSolver::finish(const LaplaceProblem& problem, LaplaceSolution& solution) {
  solution.unknowns = level->fluid_cells;
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const Group& group = problem.groups[g];
    solution.group_potential.push_back(group.floating ? unit_ * x[level->layout.size() + g] : group.potential);
  }
  evaluate(order.sorted(), *level, x.data(), unit_, solution, team);
  order.restore(solution.body_charge);
  order.restore(solution.body_force);
  if (!solution.body_torque.empty()) order.restore(solution.body_torque);
  store(problem, solution);
  if (followed) followed_then = followed->potentials();
}

void CpuSolver::store(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  std::vector<double> body_potential;
  for (const Body& body : problem.bodies) body_potential.push_back(solution.group_potential[body.group] / unit_);
  for (const std::ptrdiff_t slot : level->covered) x[slot] = body_potential[order.index(level->owner[slot].body())];
  exchange_ghosts(level->layout, x.data(), 1);  // for the operator's products with the stored solution
  history.store(x, std::move(body_potential));
}

Potentials CpuSolver::potentials() const {
  if (history.empty()) return {};
  const Layout& at = level->layout;
  Potentials found{at.nx, at.ny, {}, history.newest_of_bodies()};
  found.cell.reserve(static_cast<std::size_t>(at.nx) * at.own.count());
  for (int j = at.own.begin; j < at.own.end; ++j)
    for (int i = 0; i < at.nx; ++i) found.cell.push_back(unit_ * history.newest()[at(i, j)]);
  found.cell = gather_field(at, std::move(found.cell), true);
  for (double& potential : found.body) potential *= unit_;
  return found;
}

Field CpuSolver::last_field() const {
  if (level->layout.is_divided()) announce_gathering(number);
  Field field = field_on(level->layout, level->h, history.newest().data(), level->owner.data());
  for (int& body : field.body)
    if (body >= 0) body = order.index(body);
  field.value = gather_field(level->layout, std::move(field.value), false);
  field.body = gather_field(level->layout, std::move(field.body), false);
  return field;
}

}  // namespace

LaplaceSolution CutCellBackend::solve(const LaplaceProblem& problem) {
  try {
    start_ = std::chrono::steady_clock::now();
    parallel::start_petsc();
    prepare(problem);
    LaplaceSolution solution;
    do {
      stop_if_requested();
      discretize(problem);
      solution.seconds.setup = seconds();
      choose_unit(problem);
      stop_if_requested();
      begin(problem, solution);
      stop_if_requested();
      iterate(solution);
      solution.seconds.solve = seconds() - solution.seconds.setup;
    } while (!is_complete());
    finish(problem, solution);
    for (const Group& group : problem.groups) solution.unknowns += group.floating;
    solution.seconds.forces = std::max(0.0, seconds() - solution.seconds.setup - solution.seconds.solve);
    return solution;
  } catch (...) {
    clear_history();  // the grids hold another geometry
    throw;
  }
}

void CutCellBackend::prepare(const LaplaceProblem& problem) {
  if (box_ != problem.size) {
    finest_ = finest_grid(problem, options_.cells);
    box_ = {};
    clear_history();
    make_grids(problem);
    box_ = problem.size;
  }
  if (bodies_ != problem.bodies.size()) clear_history();
  bodies_ = problem.bodies.size();
}

/// Chooses the unit of potentials: the largest given potential if the old unit is out of range. Single precision holds
/// 38 decades either way, enough for any right-hand side of about 1. A unit within a factor of 1e6 stays, so that the
/// history needs no rescaling.
void CutCellBackend::choose_unit(const LaplaceProblem& problem) {
  double largest = 0;  // V; a charge divided by the permittivity, too
  for (const Group& group : problem.groups)
    largest = std::max(largest, std::abs(group.floating ? group.charge / problem.permittivity : group.potential));
  const Layout at(finest_.nx, finest_.ny);
  for (int side = 0; side < 4; ++side) {
    const Side& given = problem.sides[side];
    if (given.kind != Side::Kind::electrode) continue;
    for (int face = 0; face < (given.profile ? faces_of(at, side) : 1); ++face) {
      const auto [i, j] = cell_at_face(at, side, face);
      const Vec2 centre = cell_centre(i, j) + 0.5 * direction(side);
      largest = std::max(largest, std::abs(given.potential_at(problem.size.x / at.nx * centre)));
    }
  }
  const double ratio = largest / unit_;
  if (has_history() && (largest == 0 || (ratio > 1e-6 && ratio < 1e6))) return;
  clear_history();
  unit_ = largest > 0 ? largest : 1;
}

double CutCellBackend::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

Field CutCellBackend::field() const {
  if (!has_history()) throw Failure("field solver: no field before the first solve");
  return last_field();
}

Field CutCellBackend::field_on(const Layout& at, double h, const double* cell, const CellOwner* owner) const {
  Field field{at.nx, at.ny, h, {}, {}};
  for (int j = at.own.begin; j < at.own.end; ++j)
    for (int i = 0; i < at.nx; ++i) {
      const std::ptrdiff_t slot = at(i, j);
      field.value.push_back(unit_ * cell[slot]);
      field.body.push_back(owner[slot].is_fluid() ? -1 : owner[slot].body());
    }
  return field;
}

CutCellSolver::CutCellSolver(CutCellOptions options) {
  if (options.links == LinkFormula::aperture && options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    throw InputError(
        "field.boundary_stencil = \"aperture\" needs field.linear_solver = \"assembled\": the multigrid's formulas are "
        "others");
  const bool on_device = options.device == CutCellOptions::Device::cuda;
#ifndef PETSC_HAVE_CUDA
  if (on_device && options.linear_solver == CutCellOptions::LinearSolver::assembled)
    throw InputError(
        "device = \"cuda\": this program was built with a PETSc without CUDA (cmake/petsc-cuda.sh makes one)");
#endif
  if (on_device && options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    backend_ = device::make_cuda_solver(options);
  else
    backend_ = std::make_unique<CpuSolver>(options);
}
CutCellSolver::~CutCellSolver() = default;

namespace {

/// Checks bodies with a link model (a user-defined formula). Throws InputError if one is no disk, if its radius is
/// below two cells, or if a gap next to it is below three cells. Throws InputError for options that exclude link
/// models.
void check_link_models(const LaplaceProblem& problem, const CutCellOptions& options) {
  const double h = std::max(problem.size.x, problem.size.y) / options.cells, least = 3 * h;
  for (const Body& body : problem.bodies) {
    if (!body.link_model) continue;
    const auto refuse_it = [&](const std::string& why) {
      throw InputError("the link model \"" + body.link_model->name() + "\" " + why);
    };
    if (options.device == CutCellOptions::Device::cuda) refuse_it("does not run on a CUDA device");
    if (options.links == LinkFormula::aperture) refuse_it("is not allowed with field.boundary_stencil = \"aperture\"");
    const Disk* disk = std::get_if<Disk>(&body.shape);
    if (!disk) refuse_it("is for disks");
    const Vec2 c = disk->centre;
    double gap = std::min({c.x, c.y, problem.size.x - c.x, problem.size.y - c.y}) - disk->radius;
    for (const Body& other : problem.bodies)
      if (&other != &body) gap = std::min(gap, lichtenberg::gap(*disk, other.shape));
    if (disk->radius < 2 * h || gap < least)
      refuse_it("needs a radius of two cells and a gap of three to all else: more cells, or larger gaps, are allowed");
  }
}

}  // namespace

LaplaceSolution CutCellSolver::solve(const LaplaceProblem& problem) {
  problem.check();
  check_link_models(problem, backend_->options());
  const CircuitNodes nodes(problem);
  if (nodes.any()) {
    LaplaceSolution solution = solve_without_nodes(nodes.reduced());
    nodes.set_potentials(solution.group_potential);
    return solution;
  }
  return solve_without_nodes(problem);
}

LaplaceSolution CutCellSolver::solve_without_nodes(const LaplaceProblem& problem) {
  LaplaceSolution solution = backend_->solve(problem);
  check_petsc_options();
  return solution;
}

void CutCellSolver::forget() { backend_->forget(); }

void CutCellSolver::follow(const CutCellSolver& coarser) { backend_->follow(*coarser.backend_); }

void CutCellSolver::set_tolerance(double tolerance) { backend_->set_tolerance(tolerance); }

Field CutCellSolver::field() const { return backend_->field(); }

}  // namespace lichtenberg::laplace
