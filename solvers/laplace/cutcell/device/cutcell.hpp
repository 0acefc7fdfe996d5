#pragma once

#include <petscksp.h>

#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/device/rank.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace::device {

/// Names of PETSc types for an executor (CUDA device, or CPU for comparison). `vector_type`: type of the vectors;
/// `method`: name of the fused conjugate gradients. make() makes the executor on PETSc's device; PETSc must run. A
/// solver's source file specializes it for its executor.
template <class Executor>
struct PetscSide;

/// Several devices (CUDA devices, or threads of the CPU for tests). `make` makes the executor of each in its thread;
/// `least_cells`: least number of cells of a device (divided_grids()).
template <class Executor>
struct SeveralDevices {
  parallel::RankThreads threads;
  std::function<std::unique_ptr<Executor>(std::shared_ptr<parallel::Link>)> make;
  long least_cells;
};

/// Cut-cell solver that runs on an executor or on several (CUDA devices, or CPU for comparison): conductances,
/// multigrid, iterations and results. PETSc's KSP starts the iterations and reports them. On one device its vectors are
/// those of the solve; with several they have one entry, which is unused.
template <class Executor>
class CutCell : public DeviceSolver {
 public:
  explicit CutCell(const CutCellOptions& options, std::optional<SeveralDevices<Executor>> devices = {})
      : DeviceSolver(options), devices_(std::move(devices)), ranks_(devices_ ? devices_->threads.ranks() : 1) {}
  ~CutCell() override {
    release_vectors();
    if (devices_) devices_->threads.on_each([this](int r) { ranks_[r].reset(); });
  }

  void forget() override {
    for (const auto& rank : ranks_)
      if (rank) rank->forget();
  }
  void follow(const CutCellBackend& coarser) override {
    followed_ = dynamic_cast<const CutCell*>(&coarser);  // null: another kind of device
    if (devices_) followed_ = nullptr;                   // whose rows are others
    if (ranks_[0]) ranks_[0]->clear_recordings();
  }

  Profile profile(int repeats) override {
    Profile profile;
    on_all([&](int r) {
      const Profile mine = ranks_[r]->profile(repeats);
      if (r == 0) profile = mine;
    });
    return profile;
  }

  /// Computes y = A x on the finest grid of one device. All pointers are to device memory.
  void multiply(const double* x, double* y) const {
    if (!devices_) ranks_[0]->multiply(x, y);
  }
  /// Applies the preconditioner of one device, one multigrid V-cycle: z = M r.
  void precondition(const double* r, double* z) const {
    if (!devices_) ranks_[0]->precondition(r, z);
  }

  /// Runs the conjugate gradients as solve function of a PETSc KSP, then computes the results on the device. Reports
  /// the norms of the first iterations, the number of iterations and the reason of the end to `ksp`. Returns PETSc's
  /// error code.
  PetscErrorCode iterate_as_ksp(KSP ksp) {
    const double tolerance = krylov_.criterion.tolerance;
    const int most = static_cast<int>(ksp->max_it);
    const Iterations* all = nullptr;
    try {
      on_all([&](int r) {
        ranks_[r]->iterate(tolerance, most);
        const Iterations& mine = ranks_[r]->finish();
        if (r == 0) all = &mine;
      });
    } catch (...) {  // no exception may pass through PETSc's C code
      failure_ = std::current_exception();
      ksp->reason = KSP_DIVERGED_NANORINF;
      return 0;
    }
    const Iterations& found = *all;
    for (ksp->its = 0; ksp->its <= std::min(found.done, Iterations::kept - 1); ++ksp->its) {
      ksp->rnorm = found.norm[ksp->its];
      PetscCall(KSPLogResidualHistory(ksp, ksp->rnorm));
      PetscCall(KSPMonitor(ksp, ksp->its, ksp->rnorm));
    }
    ksp->its = found.done;
    krylov_.criterion.scale = found.criterion.scale;
    krylov_.criterion.record(ksp->rnorm);
    ksp->reason = is_complete() ? static_cast<KSPConvergedReason>(found.reason) : KSP_CONVERGED_ITS;
    return 0;
  }

 protected:
  void make_grids(const LaplaceProblem& problem) override {
    release_vectors();
    const long least_cells = devices_ ? devices_->least_cells : 0;
    if (devices_ && divided_grids(grid_sizes(finest_.nx, finest_.ny), devices_->threads.ranks(), least_cells) == 0)
      throw InputError("field.cells: a grid of " + std::to_string(finest_.nx) + " x " + std::to_string(finest_.ny) +
                       " cells is too small for " + std::to_string(devices_->threads.ranks()) +
                       " devices: each needs at least " + std::to_string(least_cells) + " cells");
    on_all([&](int r) {
      if (!ranks_[r])
        ranks_[r] = std::make_unique<RankSolver<Executor>>(devices_ ? devices_->make(devices_->threads.link(r))
                                                                    : PetscSide<Executor>::make());
      ranks_[r]->make_grids(problem, finest_, options_.links, least_cells);
    });
  }

  void discretize(const LaplaceProblem& problem) override {
    refuse_curves(problem, "field.device = \"cuda\"");
    on_all([&](int r) {
      ranks_[r]->upload(problem);
      if (r == 0) seconds_before_ = seconds();
      ranks_[r]->discretize(problem);
    });
    prepare_system(problem);
  }

  void begin(const LaplaceProblem& /*problem*/, LaplaceSolution& /*solution*/) override {
    on_all([&](int r) { ranks_[r]->begin(unit_, followed()); });
  }

  /// Solves the system and computes the results on the device, so that one transfer fetches everything.
  void iterate(LaplaceSolution& solution) override {
    krylov_.criterion = {options_.tolerance, 0, 0, 0};
    if (!is_fused_) return solve_by_petsc(solution);
    failure_ = nullptr;
    try {
      krylov_.solve(solution);
    } catch (...) {
      if (failure_) std::rethrow_exception(failure_);
      throw;
    }
  }

  /// Returns true if the arrays of the last solve were large enough. For moving bodies, lists of cells and conductances
  /// grow.
  bool is_complete() const override { return ranks_[0]->is_complete(); }

  void finish(const LaplaceProblem& problem, LaplaceSolution& solution) override {
    on_all([&](int r) { ranks_[r]->store(followed()); });
    ranks_[0]->copy_results(problem, solution);
    solution.seconds.setup += seconds_before_;
  }

  bool has_history() const override { return ranks_[0] && ranks_[0]->has_history(); }
  void clear_history() override {
    for (const auto& rank : ranks_)
      if (rank) rank->clear_history();
  }
  Field last_field() const override {
    std::vector<double> cell;
    std::vector<CellOwner> owner;
    on_all([&](int r) {
      std::vector<double> cell_of_rank;
      std::vector<CellOwner> owner_of_rank;
      ranks_[r]->copy_field(cell_of_rank, owner_of_rank);
      if (r == 0) cell = std::move(cell_of_rank), owner = std::move(owner_of_rank);
    });
    const Layout at(finest_.nx, finest_.ny);
    return field_on(at, ranks_[0]->cell_width(), cell.data(), owner.data());
  }

 private:
  /// Calls f(rank) for all ranks at the same time, in a thread each; on one device f(0).
  template <class F>
  void on_all(const F& f) const {
    if (devices_)
      devices_->threads.on_all(f);
    else
      f(0);
  }
  const RankSolver<Executor>* followed() const { return followed_ ? followed_->ranks_[0].get() : nullptr; }

  void release_vectors() {
    if (!parallel::petsc_started()) return;
    krylov_.release();
  }

  /// Makes the KSP on vectors for the capacity of groups (bodies with one potential), and the arrays of the solve.
  void prepare_system(const LaplaceProblem& problem) {
    const PetscInt n = devices_ ? 1 : static_cast<PetscInt>(ranks_[0]->entries());
    PetscInt have = -1;
    if (krylov_.x) parallel::check_petsc(VecGetSize(krylov_.x, &have));
    if (have != n) make_ksp(n);
    if (!is_fused_) set_null_space(problem);
    if (devices_) return on_all([&](int r) { ranks_[r]->prepare(problem, nullptr, nullptr); });
    ranks_[0]->prepare(problem, WriteAccess(krylov_.b), WriteAccess(krylov_.x));
  }

  void make_ksp(PetscInt n) {
    release_vectors();
    const char* vector_type = devices_ ? VECSEQ : PetscSide<Executor>::vector_type;
    parallel::check_petsc(VecCreate(PETSC_COMM_SELF, &krylov_.x));
    parallel::check_petsc(VecSetSizes(krylov_.x, n, n));
    parallel::check_petsc(VecSetType(krylov_.x, vector_type));
    parallel::check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
    const char* method = PetscSide<Executor>::method;
    const Shell shell = Shell::of(this, "cut-cell multigrid on the device", vector_type);
    register_natural_method<iterate_on_device<CutCell>>(method);
    krylov_.make_shell_matrix(shell, n);
    krylov_.make_shell_method(shell, options_.tolerance, method);
    is_fused_ = krylov_.is(method);
    if (krylov_.is(fused_cg)) {
      krylov_.release();
      throw InputError(std::string("-field_ksp_type ") + fused_cg + " is the CPU's: leave the option out on a device");
    }
    if (devices_ && !is_fused_) {
      krylov_.release();
      throw InputError(
          "-field_ksp_type and -field_pc_type are not allowed on several devices, which have their own conjugate "
          "gradients: leave them out");
    }
    parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
    parallel::check_petsc(KSPSetUp(krylov_.ksp));
  }

  /// Sets the null space for PETSc's methods: equal potentials if no potential is given, otherwise none.
  void set_null_space(const LaplaceProblem& problem) {
    if (problem.has_ground()) return krylov_.set_null_space(nullptr);
    krylov_.set_constant_null_space([this](double* value) { ranks_[0]->mark(value); });
  }

  /// Solves by a Krylov method of PETSc: the method of the option -field_ksp_type, or plain CG if -field_pc_type none
  /// replaces the multigrid.
  void solve_by_petsc(LaplaceSolution& solution) {
    const Iterations& start = ranks_[0]->begin_for_petsc();
    krylov_.criterion.energy_norm = start.criterion.energy_norm;
    krylov_.criterion.rounding = start.criterion.rounding;
    krylov_.solve(solution);
    ranks_[0]->finish();
  }

  Krylov krylov_;
  bool is_fused_ = true;  // the KSP is iterate()
  std::optional<SeveralDevices<Executor>> devices_;
  std::vector<std::unique_ptr<RankSolver<Executor>>> ranks_;
  double seconds_before_ = 0;          // the last discretization
  const CutCell* followed_ = nullptr;  // the solver on a coarser grid
  std::exception_ptr failure_;         // of the iterations
};

}  // namespace lichtenberg::laplace::device
