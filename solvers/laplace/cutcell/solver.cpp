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
#include "solvers/laplace/cutcell/body_order.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/follow.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/history.hpp"
#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/laplace/cutcell/matrix_free.hpp"
#include "solvers/laplace/cutcell/results.hpp"
#include "solvers/laplace/cutcell/shares.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Unless told, no more threads than the finest grid's loops have bands for. The assembled system is PETSc's.
int team_size(const CutCellOptions& options) {
  if (options.linear_solver == CutCellOptions::LinearSolver::assembled) return 1;
  if (options.threads > 0) return options.threads;
  const long useful = static_cast<long>(options.cells) * options.cells / cells_a_band;
  const long available = std::max(1u, std::thread::hardware_concurrency());
  return static_cast<int>(std::clamp(useful, 1L, available));
}

/// Of a first guess before CG starts. Four cost a third of a residual evaluation and take its error in the energy norm
/// down to an eighth.
constexpr int edge_sweeps = 4;

/// The solver on the CPU.
class CpuSolver : public CutCellBackend {
 public:
  explicit CpuSolver(CutCellOptions o) : options(o) {
    static int solvers = 0;
    number = solvers++;
  }
  ~CpuSolver() override {
    if (assembled()) announce_end(number);
  }

  LaplaceSolution solve(const LaplaceProblem& problem) override {
    if (assembled()) announce_solve(number, options, problem);
    try {
      return solve_here(problem);
    } catch (...) {
      history.clear();  // it is of a geometry that has gone
      throw;
    }
  }
  Field field() const override;
  void forget() override {
    if (assembled()) announce_forgetting(number);
    history.clear();
  }
  void follow(const CutCellBackend& coarser) override { followed = dynamic_cast<const CpuSolver*>(&coarser); }
  void set_tolerance(double tolerance) override { options.tolerance = tolerance; }

 private:
  bool assembled() const { return options.linear_solver == CutCellOptions::LinearSolver::assembled; }

  CutCellOptions options;
  int number;  // among the solvers of this program, for its other processes
  parallel::Team team{team_size(options)};
  Vec2 size;  // of the box the grids were made for
  BodyOrder order;
  std::unique_ptr<Level> level;
  CutCellOperator op;
  std::unique_ptr<LinearSystem> system;
  std::vector<double> b, x, residual;   // layout + groups
  double scale = 1;                     // V: x, b and the history are in units of it
  History history;                      // bodies' potentials in the order of the problems
  const CpuSolver* followed = nullptr;  // the solver on a coarser grid
  Potentials followed_then;             // its solution at the last solve here; of no body: none

  LaplaceSolution solve_here(const LaplaceProblem& problem);
  void choose_scale(const LaplaceProblem& problem);
  double rounding_of_residual(const std::vector<double>& potentials) const;
  void prepare_grids(const LaplaceProblem& problem);
  void fix_mean(const LaplaceProblem& problem);
  double first_guess(const LaplaceProblem& problem);
  Potentials potentials() const;
  void remember(const LaplaceProblem& problem, const LaplaceSolution& solution);
};

/// Whatever is thrown, no helper goes on with a problem that has gone.
class Finished {
 public:
  explicit Finished(LinearSystem& system) : system_(system) {}
  Finished(const Finished&) = delete;
  Finished& operator=(const Finished&) = delete;
  ~Finished() {
    try {
      system_.finish();
    } catch (...) {
      // What was thrown first is on its way.
    }
  }

 private:
  LinearSystem& system_;
};

std::unique_ptr<LinearSystem> make_system(const CutCellOptions& options, parallel::Team& team) {
  if (options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    return std::make_unique<MatrixFreeSystem>(options.links, options.tolerance, team);
  return std::make_unique<AssembledSystem>(options.links, options.tolerance, options.device);
}

void CpuSolver::prepare_grids(const LaplaceProblem& problem) {
  if (level && size == problem.size) return;
  const GridSize finest = finest_grid(problem, options.cells);
  level = std::make_unique<Level>(problem, finest.nx, finest.ny);
  system = make_system(options, team);
  history.clear();
  size = problem.size;
}

void CpuSolver::fix_mean(const LaplaceProblem& problem) {
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

void CpuSolver::remember(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  std::vector<double> body_potential;
  for (const Body& body : problem.bodies) body_potential.push_back(solution.group_potential[body.group] / scale);
  for (const std::ptrdiff_t slot : level->covered) x[slot] = body_potential[order.index(level->cover[slot].body())];
  history.remember(x, std::move(body_potential));
}

void CpuSolver::choose_scale(const LaplaceProblem& problem) {
  double largest = 0;
  for (const Group& group : problem.groups)
    largest = std::max(largest, std::abs(group.floating ? group.charge / problem.permittivity : group.potential));
  for (const SideLink& link : level->side_links) largest = std::max(largest, std::abs(link.potential));
  if (const std::optional<double> unit = new_potential_unit(largest, scale, !history.empty())) {
    history.clear();
    scale = *unit;
  }
}

/// A row adds some five potentials of at most |x|, which leaves a residual of about epsilon |x|, random from row to
/// row. Its natural norm squared is the sum of that squared over the Laplacian's eigenvalues, 4 pi k of the k-th of n
/// modes: epsilon^2 x^2 n (log n) / 4 pi, in which log n / 4 pi is about 1.
double CpuSolver::rounding_of_residual(const std::vector<double>& potentials) const {
  const Eigen::Map<const Eigen::VectorXd> all(potentials.data(), static_cast<Eigen::Index>(potentials.size()));
  return std::numeric_limits<double>::epsilon() * std::sqrt(static_cast<double>(potentials.size())) *
         all.lpNorm<Eigen::Infinity>();
}

/// Returns its work, in evaluations of the operator.
double CpuSolver::first_guess(const LaplaceProblem& problem) {
  if (history.empty()) {
    system->finish();
    system->first_guess(order.sorted(), scale, x);
    return 0;
  }
  const std::size_t bodies = problem.bodies.size();
  if (!followed || followed->history.empty() || followed->history.bodies() != bodies ||
      followed_then.body.size() != bodies)
    return history.first_guess(problem, op, b, x);
  history.newest_guess(problem, op, x);
  add_change(followed_then, followed->potentials(), problem, scale, op, x);
  return 0;
}

Potentials CpuSolver::potentials() const {
  if (history.empty()) return {};
  const Layout& at = level->layout;
  Potentials found{at.nx, at.ny, {}, history.newest_of_bodies()};
  found.cell.reserve(static_cast<std::size_t>(at.nx) * at.ny);
  for (int j = 0; j < at.ny; ++j)
    for (int i = 0; i < at.nx; ++i) found.cell.push_back(scale * history.newest()[at(i, j)]);
  for (double& potential : found.body) potential *= scale;
  return found;
}

LaplaceSolution CpuSolver::solve_here(const LaplaceProblem& problem) {
  parallel::start_petsc();
  LaplaceSolution solution;
  auto start = std::chrono::steady_clock::now();
  prepare_grids(problem);
  order.sort(problem, level->layout.ny);
  const LaplaceProblem& sorted = order.sorted();
  if (!history.empty() && history.bodies() != sorted.bodies.size()) history.clear();
  const Finished finished(*system);
  system->build(sorted, *level, op);
  for (std::vector<double>* vector : {&x, &b, &residual}) parallel::resize_in_huge_pages(*vector, op.size());
  solution.seconds.setup = seconds_since(start);

  start = std::chrono::steady_clock::now();
  choose_scale(sorted);
  op.right_hand_side(sorted, b.data(), scale);
  solution.work += first_guess(problem);
  solution.work += op.relax_edges(b.data(), x.data(), edge_sweeps);
  const double guess_norm = op.stretch(b.data(), x.data(), residual.data());
  solution.work += 1;
  if (op.grounded_by_couplings()) op.level_out(x.data(), residual.data());
  system->finish();
  system->solve(b, x, residual, {options.tolerance, guess_norm, 0, 0, rounding_of_residual(x)}, solution);
  op.balance(sorted, scale, b.data(), x.data());
  if (!sorted.has_ground()) fix_mean(sorted);
  solution.seconds.solve = seconds_since(start);

  start = std::chrono::steady_clock::now();
  solution.unknowns = level->fluid_cells;
  for (const Group& group : sorted.groups) solution.unknowns += group.floating;
  solution.group_potential.resize(sorted.groups.size());
  for (std::size_t g = 0; g < sorted.groups.size(); ++g)
    solution.group_potential[g] =
        sorted.groups[g].floating ? scale * x[level->layout.size() + g] : sorted.groups[g].potential;
  evaluate(sorted, *level, x.data(), scale, solution, team);
  order.restore(solution.body_charge);
  order.restore(solution.body_force);
  remember(problem, solution);
  if (followed) followed_then = followed->potentials();
  solution.seconds.forces = seconds_since(start);
  return solution;
}

Field CpuSolver::field() const {
  if (history.empty()) throw Failure("field solver: no field before the first solve");
  Field field{level->layout.nx, level->layout.ny, level->h, {}, {}};
  for (int j = 0; j < field.ny; ++j)
    for (int i = 0; i < field.nx; ++i) {
      const std::ptrdiff_t slot = level->layout(i, j);
      field.value.push_back(scale * history.newest()[slot]);
      field.body.push_back(level->cover[slot].is_fluid() ? -1 : order.index(level->cover[slot].body()));
    }
  return field;
}

}  // namespace

CutCellSolver::CutCellSolver(CutCellOptions options) : options_(options) {
  if (options.links == LinkFormula::aperture && options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    throw InputError(
        "field.boundary_stencil = \"aperture\" needs field.linear_solver = \"assembled\": the multigrid's formulas are "
        "others");
  const bool on_device = options.device == CutCellOptions::Device::cuda;
#ifndef PETSC_HAVE_CUDA
  if (on_device && options.linear_solver == CutCellOptions::LinearSolver::assembled)
    throw InputError("device = \"cuda\": this program stands on a PETSc without CUDA (cmake/petsc-cuda.sh makes one)");
#endif
  if (on_device && options.linear_solver == CutCellOptions::LinearSolver::multigrid)
    backend_ = device::make_cuda_solver(options);
  else
    backend_ = std::make_unique<CpuSolver>(options);
}
CutCellSolver::~CutCellSolver() = default;

namespace {

/// Throws InputError where a body with a link model would need formulas that it does not have: those of bodies that the
/// grid does not resolve, and of two surfaces with less than a fluid cell on each side between them.
void check_link_models(const LaplaceProblem& problem, const CutCellOptions& options) {
  const double h = std::max(problem.size.x, problem.size.y) / options.cells, least = 3 * h;
  for (const Body& body : problem.bodies) {
    if (!body.link_model) continue;
    const auto refuse_it = [&](const std::string& why) {
      throw InputError("the link model \"" + body.link_model->name() + "\" " + why);
    };
    if (options.device == CutCellOptions::Device::cuda) refuse_it("does not run on a CUDA device");
    if (options.links == LinkFormula::aperture) refuse_it("does not go with links = \"aperture\"");
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
  check_link_models(problem, options_);
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
