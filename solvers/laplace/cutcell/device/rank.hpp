#pragma once

// Cut-cell solver of one device: grids, vectors, iterations, results and history of solutions. It does not call PETSc,
// because several of them run in threads (cutcell.hpp).

#include <petscksp.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/backend.hpp"
#include "solvers/laplace/cutcell/device/charge_correction.hpp"
#include "solvers/laplace/cutcell/device/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/device/follow.hpp"
#include "solvers/laplace/cutcell/device/initial_guess.hpp"
#include "solvers/laplace/cutcell/device/multigrid.hpp"
#include "solvers/laplace/cutcell/device/results.hpp"

namespace lichtenberg::laplace::device {

/// Cut-cell solver on one executor (CUDA device, or CPU for comparison). Of several ranks, all make the same calls at
/// the same time. Steps of a solve: upload(), discretize(), prepare(), begin(), iterate(), finish(), store().
template <class Executor>
class RankSolver {
 public:
  explicit RankSolver(std::unique_ptr<Executor> run) : run_(std::move(run)) {}

  /// Makes the grids for a new box. `least_cells`: divided_grids(). Throws Failure if the device lacks memory.
  void make_grids(const LaplaceProblem& problem, GridSize finest, LinkFormula formula, long least_cells) {
    const Executor& run = *run_;
    multigrid_.reset();
    history_.clear();
    check_memory(problem, finest);
    problem_ = std::make_unique<DeviceProblem<Executor>>(run);
    multigrid_ = std::make_unique<DeviceMultigrid<Executor>>(run, problem, finest.nx, finest.ny, formula, least_cells);
    generation_ = 0;
    moments_.emplace();
    for (int k = 0; k < history_length; ++k) history_.emplace_back(run);
    arrays_.emplace(run);
    follower_.emplace(run);
    report_.emplace(run);
  }
  /// Copies the problem to the device.
  void upload(const LaplaceProblem& problem) {
    const Layout& at = finest().view().layout;
    problem_->upload(problem, at.nx, at.ny);
  }
  /// Discretizes the problem on all grids.
  void discretize(const LaplaceProblem& problem) {
    run_->mark(moments_->begun);
    multigrid_->build(problem, problem_->view());
  }
  /// Returns the number of entries of a vector: slots (memory indices) of cells, then groups (bodies with one
  /// potential).
  long entries() const { return static_cast<long>(finest().view().layout.size()) + problem_->view().groups; }
  /// Makes the arrays of the solve for the grids of discretize(). `b`, `x`: right-hand side and potentials in the
  /// device's memory; null: own arrays.
  void prepare(const LaplaceProblem& problem, double* b, double* x) {
    if (b) {
      arrays_->view.solve.b = b;
      arrays_->view.solve.x = x;
    }
    if (generation_ != multigrid_->generation()) reserve(problem, !b);
    run_->mark(moments_->discretized);
  }
  /// Computes the right-hand side and the initial guess, in units of `unit` (V). `followed`: solver on a coarser grid,
  /// or null.
  void begin(double unit, const RankSolver* followed) {
    if (unit != unit_) recordings_.clear();
    unit_ = unit;
    const CoarseSolution ahead = followed ? followed->last_solution() : CoarseSolution{};
    const bool follows = history_size_ > 0 && follower_->is_comparable(ahead);
    if (follows) follower_->compare(ahead, unit_);
    const auto both = [this, follows] {
      const SolveVectors& v = arrays_->view.solve;
      right_hand_side(*run_, problem_->view(), finest().view(), v.b, unit_);
      if (follows)
        follow_change(*run_, problem_->view(), finest().view(), history_[0].view, follower_->change(), v.x);
      else
        initial_guess();
    };
    if (follows)
      run_as_graph(recordings_.following[phase_], both);
    else if (history_size_ == history_length)
      run_as_graph(recordings_.begin[phase_], both);
    else
      both();
  }
  /// Runs at most `most` iterations of conjugate gradients.
  void iterate(double tolerance, int most) {
    Iterations* iterations = report_->iterations.device;
    begin_iterations(*run_, tolerance, most, iterations);
    if (multigrid_->on_device() && run_->ranks() == 1) {
      run_->run(recordings_.iterating, [&] {
        improve_guess();
        run_->repeat([this](auto again) { iterate_once(again); });
      });
      return;
    }
    improve_guess();
    const auto host_asks = [] LICHTENBERG_HOST_DEVICE(bool) {};
    int go_on = 1;
    while (go_on) {
      iterate_once(host_asks);
      run_->to_host(&go_on, &iterations->go_on, sizeof go_on);
    }
  }
  /// Improves the guess for a solve by a method of PETSc, and copies the state of the iterations to the host.
  const Iterations& begin_for_petsc() {
    begin_iterations(*run_, 0, 0, report_->iterations.device);
    improve_guess();
    report_->parcel.fetch();
    return *report_->iterations.host;
  }
  /// Computes charges, forces and energy on the device and copies them with the potentials to the host. Checks that no
  /// array of the device was too small. Returns the state of the iterations.
  const Iterations& finish() {
    run_->mark(moments_->iterated);
    run_as_graph(recordings_.end, [this] { evaluate(); });
    multigrid_->begin_capacity_check();
    report_->parcel.fetch();
    is_complete_ = multigrid_->check_capacity();
    return *report_->iterations.host;
  }
  /// Returns true if the arrays of the last solve were large enough.
  bool is_complete() const { return is_complete_; }
  /// Adds the potentials to the history of solutions. `followed`: as in begin().
  void store(const RankSolver* followed) {
    std::rotate(history_.begin(), history_.end() - 1, history_.end());
    phase_ = (phase_ + 1) % history_length;
    history_[0].resize(finest().view().layout.size(), history_[0].view.cell);
    history_[0].resize(problem_->view().bodies, history_[0].view.body);
    store_solution(*run_, solved(), history_[0].view);
    history_size_ = std::min(history_size_ + 1, history_length);
    if (followed) follower_->keep(followed->last_solution());
  }
  /// Stores the results that finish() has copied to the host.
  void copy_results(const LaplaceProblem& problem, LaplaceSolution& solution) const {
    const std::size_t bodies = problem.bodies.size();
    solution.unknowns = multigrid_->fluid_cells();
    solution.group_potential.assign(report_->potential.host, report_->potential.host + problem.groups.size());
    solution.energy = 0;
    solution.body_charge.resize(bodies);
    solution.body_force.resize(bodies);
    for (std::size_t k = 0; k < bodies; ++k) {
      const BodyResult& body = report_->body_result.host[k];
      solution.energy += 0.5 * body.charge * solution.group_potential[problem.bodies[k].group];
      solution.body_charge[k] = body.charge;
      solution.body_force[k] = {body.force_x, body.force_y};
    }
    solution.side_charge = {};
    for (int part = 0; part < 4 * side_parts; ++part) {
      solution.side_charge[part / side_parts] += report_->side_result.host[part].charge;
      solution.energy += report_->side_result.host[part].energy;
    }
    solution.seconds.setup = moments_->discretized.seconds_since(moments_->begun);
    solution.seconds.solve = moments_->iterated.seconds_since(moments_->discretized);
  }

  /// Returns the width of the finest grid's cells (m).
  double cell_width() const { return finest().view().h; }
  bool has_history() const { return history_size_ > 0; }
  void clear_history() { history_size_ = 0; }
  void forget() {
    clear_history();
    if (multigrid_) multigrid_->forget();
  }
  /// Discards the recorded graphs.
  void clear_recordings() { recordings_.clear(); }
  /// Copies the last solution and the cells' owners to the host, by slot (memory index). Of several ranks, each gets
  /// all rows.
  void copy_field(std::vector<double>& cell, std::vector<CellOwner>& owner) const {
    const GridView& grid = finest().view();
    exchange_ghosts(*run_, grid, history_[0].view.cell, grid.layout.ny);
    cell.resize(grid.layout.size());
    owner.resize(grid.layout.size());
    run_->to_host(cell.data(), history_[0].view.cell, cell.size() * sizeof(double));
    run_->to_host(owner.data(), grid.cells.owner, owner.size() * sizeof(CellOwner));
  }

  /// Computes y = A x on the finest grid. All pointers are to device memory.
  void multiply(const double* x, double* y) const { apply_operator(*run_, problem_->view(), finest().view(), x, y); }
  /// Applies the preconditioner, one multigrid V-cycle: z = M r.
  void precondition(const double* r, double* z) const { multigrid_->apply(r, z); }
  /// Sets v to 1 for every unknown and to 0 elsewhere.
  void mark(double* v) const { mark_unknowns(*run_, problem_->view(), finest().view(), v); }
  /// As DeviceSolver::profile().
  Profile profile(int repeats) {
    Profile profile;
    const SolveVectors& vectors = arrays_->view.solve;
    double *r = vectors.b, *z = vectors.p, *y = vectors.q;
    const GridView& grid = finest().view();
    const auto per_call = [&](auto f) {
      f();
      return run_->seconds([&] {
        for (int k = 0; k < repeats; ++k) f();
      }) / repeats;
    };
    const double cells = static_cast<double>(grid.layout.size());
    profile.apply_operator.seconds = per_call([&] {
      exchange_ghosts(*run_, grid, r, ghosts_of_product);
      multiply(r, z);
    });
    // x and 1 / diagonal read, y written
    profile.apply_operator.bytes = cells * (8 + 4 + 8);
    profile.cycle.seconds = per_call([&] { multigrid_->apply(r); });
    // Bytes per cell, half of the grid being red. The terms are: the residual stored; f and 1 / diagonal read for black
    // cells; black cells and 1 / diagonal of red ones read for the residual, which goes to the coarse f. In the second
    // half: f, 1 / diagonal and coarse v read for black cells; black cells, f and 1 / diagonal read for red cells.
    // Coarser grids have a third of the cells together.
    constexpr double bytes = (8 + 2) + (2 + 2 + 2) + (2 + 1) + (8 + 1 + 2) + (2 + 4 + 2);
    profile.cycle.bytes = cells * (8 + 4 + bytes) + cells / 3 * bytes;
    profile.copy.seconds = per_call([&] { run_->copy(y, z, static_cast<std::size_t>(cells) * sizeof(double)); });
    profile.copy.bytes = 16 * cells;
    profile.levels = multigrid_->levels();
    profile.coarse_unknowns = multigrid_->coarse_unknowns();
    clear_history();
    return profile;
  }

  // Public because nvcc requires it of functions with kernels.

  /// Makes one CG iteration: a V-cycle, then a step unless the residual is already small enough. `again`: continuation
  /// that receives whether another iteration follows.
  template <class Continuation>
  void iterate_once(Continuation again) {
    const ProblemView& problem = problem_->view();
    const GridView& grid = finest().view();
    const SolveVectors& v = arrays_->view.solve;
    multigrid_->cycle();
    if (!problem.grounded) remove_mean(*run_, problem, grid, v.z, report_->potential.device + problem.groups);
    test_convergence(*run_, problem, grid, v);
    update_direction(*run_, problem, grid, v);
    compute_step(*run_, problem, grid, v, again);
    take_step(*run_, problem, grid, v);
  }

 private:
  using StoredSolution = parallel::Arrays<SolutionView, Executor>;
  using TimePoint = typename Executor::TimePoint;
  using Recording = typename Executor::Recording;
  template <class T>
  using Transferred = typename parallel::PackedTransfer<Executor>::template MirroredArray<T>;
  struct Moments {
    TimePoint begun, discretized, iterated;
  };
  struct Recordings {
    Recording begin[history_length], following[history_length];  ///< by phase_
    Recording iterating, end;
    void clear() {
      for (auto* all : {&begin, &following})
        for (Recording& recording : *all) recording.clear();
      iterating.clear();
      end.clear();
    }
  };
  /// Data that the host fetches at the end of a solve: state of the iterations, group potentials, results of bodies and
  /// sides. A group is a set of bodies with one potential.
  struct Report {
    explicit Report(const Executor& run) : parcel(run) {}
    parallel::PackedTransfer<Executor> parcel;
    Transferred<Iterations> iterations;
    /// By group (V), followed by the mean or the common shift of x.
    Transferred<double> potential;
    Transferred<BodyResult> body_result;
    Transferred<SideResult> side_result;
  };
  /// Arrays of a solve in device memory: vectors, basis of the initial guess, charge correction.
  struct Vectors {
    /// Vectors of the conjugate gradients; x and b belong to the KSP.
    SolveVectors solve;
    double* next_potential;
    BasisView basis;
    ChargeCorrection correction;
  };
  CoarseSolution last_solution() const {
    if (history_size_ == 0) return {};
    return {finest().view().layout, problem_->view().bodies, history_[0].view, unit_};
  }
  const DeviceGrid<Executor>& finest() const { return multigrid_->finest(); }

  /// Estimates the memory for grids, conductances and vectors. Throws Failure if the device has less free memory.
  void check_memory(const LaplaceProblem& problem, GridSize finest) const {
    // Double precision: x, b, three vectors of CG and the history; then the grids' owners, diagonals, v, f and media,
    // and the guess of the first coarse grid.
    constexpr double a_cell = (5 + history_length) * sizeof(double) + 16 + 28 / 3.0 + 1;
    // A disk of R cells has 8 R links, 5.7 R cells next to it and pi R^2 in it; the coarser grids' edges are as long
    // together as the finest's; a quarter to spare.
    constexpr double a_link = 68, a_boundary_cell = 36, a_covered_cell = 8, spare = 1.25;
    double bytes = a_cell * finest.nx * finest.ny;
    const double h = problem.size.x / finest.nx;
    for (const Body& body : problem.bodies) {
      const Outline outline = outline_in_cells(body.shape, h);
      const double radius = outline.round() ? outline.size : 0.5 * (outline.size + norm(outline.end - outline.centre));
      bytes += spare * (2 * (8 * a_link + 5.7 * a_boundary_cell) * radius + 4.2 * a_covered_cell * radius * radius);
    }
    if (!problem.couplings.empty()) {
      // All groups in one cluster, on each grid from 8 cells a side on (clustering.hpp).
      const auto floating = std::ranges::count(problem.groups, true, &Group::floating);
      bytes += sizeof(double) * (std::log2(finest.nx / 8.0) + 2) * static_cast<double>(floating) * floating;
    }
    const double free_bytes = static_cast<double>(run_->available_memory());
    if (bytes <= free_bytes) return;
    const auto in_mib = [](double b) { return std::to_string(static_cast<long>(b / (1 << 20))) + " MiB"; };
    throw Failure("the field on " + std::to_string(finest.nx) + " x " + std::to_string(finest.ny) + " cells around " +
                  std::to_string(problem.bodies.size()) + " conductors needs " + in_mib(bytes + (1 << 20)) +
                  " of the device's memory, of which " + in_mib(free_bytes) + " are free");
  }

  /// Makes the arrays for the present capacity of groups (bodies with one potential). `has_own_vectors`: those of the
  /// right-hand side and the potentials, too.
  void reserve(const LaplaceProblem& problem, bool has_own_vectors) {
    const int groups = problem_->view().groups;
    const long n = entries();
    generation_ = multigrid_->generation();
    recordings_.clear();
    Vectors& v = arrays_->view;
    v.solve.size = n;
    for (int k = 0; k < history_length; ++k) arrays_->resize(groups, v.basis.vector[k], v.basis.image[k]);
    arrays_->resize(n, v.solve.r, v.solve.p, v.solve.q);
    if (has_own_vectors) {
      arrays_->resize(n, v.solve.b, v.solve.x);
      arrays_->zero(v.solve.x, v.solve.p);  // rows of other ranks, and padding
    }
    v.solve.z = multigrid_->result();
    arrays_->resize(1, v.basis.products);
    arrays_->resize(1, v.basis.shares);
    ChargeCorrection& correction = v.correction;
    arrays_->resize(groups, v.next_potential, correction.residual, correction.shift, correction.hold, correction.held,
                    correction.to_cells, correction.from_cells, correction.r, correction.p, correction.q,
                    correction.is_linked);
    arrays_->resize(SolveGroups::threads * ((groups + SolveGroups::threads - 1) / SolveGroups::threads),
                    correction.linked);
    std::tie(report_->iterations, report_->potential, report_->body_result, report_->side_result) =
        report_->parcel.template divide<Iterations, double, BodyResult, SideResult>(
            {1, static_cast<std::size_t>(groups) + 1, problem.bodies.size(), 4 * side_parts});
    v.solve.iterations = report_->iterations.device;
    correction.level = report_->potential.device + groups;
  }

  /// Computes the initial guess from the history of solutions, as SolutionHistory::initial_guess. Without a history
  /// computes it by nested iteration on large grids (DeviceMultigrid::nested_guess), otherwise sets it to zero.
  void initial_guess() {
    const ProblemView& problem = problem_->view();
    const GridView& grid = finest().view();
    Vectors& v = arrays_->view;
    constexpr long least_cells = 1 << 20;  // below, the nested guess takes the time of the iterations that it saves
    const bool is_large = static_cast<long>(grid.layout.nx) * grid.layout.ny >= least_cells;
    if (history_size_ == 0 && is_large && multigrid_->has_nested_guess())
      return multigrid_->nested_guess(unit_, v.solve.x);
    if (history_size_ == 0) return run_->fill(v.solve.x, 0, v.solve.size * sizeof(double));
    v.basis.size = history_size_;
    for (int p = 0; p < history_size_; ++p) v.basis.solution[p] = history_[p].view;
    compute_shares(*run_, problem, grid, v.basis, v.solve.b);
    combine(*run_, problem, grid, v.basis, v.solve.x);
  }

  /// Relaxes the initial guess near the conductors, where its error is largest, scales it, and computes its residual.
  /// If only couplings (lumped capacitances) lead to given potentials, also fixes the common shift of the potentials.
  void improve_guess() {
    const SolveVectors& v = arrays_->view.solve;
    const ProblemView& problem = problem_->view();
    const GridView& grid = finest().view();
    // A sweep of both colours reads two rows, and the product that follows one.
    exchange_ghosts(*run_, grid, v.x, 2 * edge_sweeps + ghosts_of_product);
    relax_edges(*run_, problem, grid, v, arrays_->view.next_potential, edge_sweeps);
    scale_guess(*run_, problem, grid, v);
    if (problem.couplings.only_ground)
      fix_potential_level(*run_, problem, grid, v, report_->potential.device + problem.groups);
  }

  /// Computes charges, forces, energies and group potentials from x on the device. A group is a set of bodies with one
  /// potential.
  void evaluate() {
    const ProblemView& problem = problem_->view();
    const GridView& grid = finest().view();
    const SolveVectors& v = arrays_->view.solve;
    correct_charges(*run_, problem, grid, v, unit_, arrays_->view.correction);
    if (!problem.grounded) fix_mean(*run_, problem, grid, v.x, report_->potential.device + problem.groups);
    group_potentials(*run_, problem, grid, v.x, unit_, report_->potential.device);
    sum_bodies(*run_, solved(), report_->body_result.device);
    sum_sides(*run_, solved(), report_->side_result.device);
  }
  SolvedView solved() const {
    return {problem_->view(), finest().view(), arrays_->view.solve.x, unit_, report_->potential.device};
  }

  /// Runs the kernels of f as a graph, which is recorded once. If the host takes part in each V-cycle, calls f instead.
  template <class F>
  void run_as_graph(Recording& recording, F f) {
    if (multigrid_->on_device())
      run_->run(recording, f);
    else
      f();
  }

  std::unique_ptr<Executor> run_;
  std::unique_ptr<DeviceProblem<Executor>> problem_;
  std::unique_ptr<DeviceMultigrid<Executor>> multigrid_;
  std::optional<Moments> moments_;
  int generation_ = 0;  // of the grids that the recordings are for
  std::optional<parallel::Arrays<Vectors, Executor>> arrays_;
  Recordings recordings_;
  double unit_ = 1;                             // of the potentials (V), also in the recordings
  std::vector<StoredSolution> history_;         // newest first
  int history_size_ = 0, phase_ = 0;            // phase_: says where in memory the newest is
  std::optional<Follower<Executor>> follower_;  // the coarser solution at the last solve here
  std::optional<Report> report_;
  bool is_complete_ = false;
};

}  // namespace lichtenberg::laplace::device
