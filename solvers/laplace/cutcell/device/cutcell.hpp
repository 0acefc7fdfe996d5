#pragma once

#include <petscksp.h>

#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/device/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/device/multigrid.hpp"
#include "solvers/laplace/cutcell/device/results.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/history.hpp"
#include "solvers/laplace/cutcell/krylov.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace::device {

/// Vec's memory on the device for as long as this lives.
class ReadAccess {
 public:
  explicit ReadAccess(::Vec vector) : vector_(vector) {
    parallel::check_petsc(VecGetArrayReadAndMemType(vector_, &data_, nullptr));
  }
  ReadAccess(const ReadAccess&) = delete;
  ReadAccess& operator=(const ReadAccess&) = delete;
  ~ReadAccess() { VecRestoreArrayReadAndMemType(vector_, &data_); }
  operator const double*() const { return data_; }

 private:
  ::Vec vector_;
  const PetscScalar* data_ = nullptr;
};

class WriteAccess {
 public:
  explicit WriteAccess(::Vec vector) : vector_(vector) {
    parallel::check_petsc(VecGetArrayAndMemType(vector_, &data_, nullptr));
  }
  WriteAccess(const WriteAccess&) = delete;
  WriteAccess& operator=(const WriteAccess&) = delete;
  ~WriteAccess() { VecRestoreArrayAndMemType(vector_, &data_); }
  operator double*() const { return data_; }

 private:
  ::Vec vector_;
  PetscScalar* data_ = nullptr;
};

/// What PETSc calls an executor's things, said where a solver is made on it: `vector_type`; `method`, the name of the
/// fused conjugate gradients on it; make(), the executor on PETSc's device (PETSc runs by then).
template <class Executor>
struct PetscSide;

/// The cut-cell solver on an executor's device: ../solver.cpp with the vectors, the grids and the sums over there.
template <class Executor>
class CutCell : public DeviceSolver {
 public:
  explicit CutCell(const CutCellOptions& options) : options_(options) {}
  ~CutCell() override { release_vectors(); }

  LaplaceSolution solve(const LaplaceProblem& problem) override {
    problem.check();
    refuse_couplings(problem, "the cut-cell solver on a device");
    LaplaceSolution solution;
    auto start = std::chrono::steady_clock::now();
    prepare_grids(problem);
    problem_->upload(problem, nx_, ny_);
    multigrid_->build(problem, problem_->view());
    prepare_system(problem);
    run_->wait();
    solution.seconds.setup = since(start);

    start = std::chrono::steady_clock::now();
    make_right_hand_side();
    krylov_.criterion = {options_.tolerance, first_guess(), 0, 0};
    krylov_.solve(solution);
    finish_potentials(problem, solution);
    solution.seconds.solve = since(start);

    start = std::chrono::steady_clock::now();
    evaluate(problem, solution);
    keep();
    run_->wait();
    solution.seconds.forces = since(start);
    return solution;
  }

  Field field() const override {
    if (past_count_ == 0) throw Failure("field solver: no field before the first solve");
    const GridView& grid = multigrid_->finest().view();
    const Layout& at = grid.layout;
    std::vector<double> cell(at.size());
    std::vector<Cover> cover(at.size());
    run_->to_host(cell.data(), past_[0].cell.data(), cell.size() * sizeof(double));
    run_->to_host(cover.data(), grid.cover, cover.size() * sizeof(Cover));
    Field field{nx_, ny_, grid.h, {}, {}};
    for (int j = 0; j < ny_; ++j)
      for (int i = 0; i < nx_; ++i) {
        const std::ptrdiff_t slot = at(i, j);
        field.value.push_back(scale_ * cell[slot]);
        field.body.push_back(cover[slot].is_fluid() ? -1 : cover[slot].body());
      }
    return field;
  }

  void forget() override { past_count_ = 0; }
  void set_tolerance(double tolerance) override { options_.tolerance = tolerance; }
  Profile profile(int repeats) override;

  void multiply(const double* x, double* y) const {
    apply_operator(*run_, problem_->view(), finest().view(), x, y, finest().partial());
  }
  void precondition(const double* r, double* z) const { multigrid_->apply(r, z); }

  // What the fused method (conjugate_gradients.hpp) is made of.
  void precondition_taken(::Vec z) const { multigrid_->apply(WriteAccess(z)); }
  void start(::Vec b, ::Vec x, ::Vec r, ::Vec q) const {
    const ReadAccess given(b), guess(x);
    const WriteAccess image(q), residual(r);
    multiply(guess, image);
    subtract_from<Executor>(*run_, problem_->view(), finest().view(), given, image, residual);
  }
  void turn(::Vec z, double beta, ::Vec p, ::Vec q) const {
    const ReadAccess preconditioned(z);
    const WriteAccess direction(p), image(q);
    turn_direction<Executor>(*run_, problem_->view(), finest().view(), preconditioned, beta, direction);
    multiply(direction, image);
  }
  void step(double alpha, ::Vec p, ::Vec q, ::Vec x, ::Vec r) const {
    const ReadAccess direction(p), image(q);
    const WriteAccess solution(x), residual(r);
    step_along<Executor>(*run_, problem_->view(), finest().view(), alpha, direction, image, solution, residual);
  }

 private:
  struct Past {
    parallel::Array<double, Executor> cell, body;
    PastView view() const { return {cell.data(), body.data()}; }
  };
  static constexpr int history_length = 3;

  static double since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  const DeviceGrid<Executor>& finest() const { return multigrid_->finest(); }

  void prepare_grids(const LaplaceProblem& problem);
  void prepare_system(const LaplaceProblem& problem);
  void release_vectors();
  void make_right_hand_side();
  double first_guess();
  void finish_potentials(const LaplaceProblem& problem, LaplaceSolution& solution);
  void evaluate(const LaplaceProblem& problem, LaplaceSolution& solution);
  void keep();
  std::vector<double> group_unknowns() const;

  CutCellOptions options_;
  std::unique_ptr<Executor> run_;
  int nx_ = 0, ny_ = 0;
  Vec2 size_;
  std::size_t bodies_ = 0, groups_ = 0;
  std::unique_ptr<DeviceProblem<Executor>> problem_;
  std::unique_ptr<DeviceMultigrid<Executor>> multigrid_;
  Krylov krylov_;
  ::Vec *basis_ = nullptr, *image_ = nullptr;
  double scale_ = 1;        // V: x, b and the past are in units of it
  std::vector<Past> past_;  // newest first
  int past_count_ = 0;
  std::optional<parallel::Array<double, Executor>> group_potential_, next_potential_;
  std::optional<parallel::Array<BodyResult, Executor>> body_result_;
  std::optional<parallel::Array<SideResult, Executor>> side_result_;
};

template <class Executor>
void CutCell<Executor>::prepare_grids(const LaplaceProblem& problem) {
  if (!run_) run_ = PetscSide<Executor>::make();
  if (bodies_ != problem.bodies.size()) forget();
  bodies_ = problem.bodies.size();
  if (multigrid_ && size_ == problem.size) return;
  const GridSize finest_size = finest_grid(problem, options_.cells);
  nx_ = finest_size.nx;
  ny_ = finest_size.ny;
  release_vectors();
  forget();
  multigrid_.reset();
  past_.clear();
  // In double: x, b, the basis and its image, four of CG, and the past; the grids' cover, diagonals, v and f.
  run_->check_room(static_cast<std::size_t>(nx_) * ny_ * ((6 + 3 * history_length) * sizeof(double) + 20));
  const Executor& run = *run_;
  problem_ = std::make_unique<DeviceProblem<Executor>>(run);
  multigrid_ = std::make_unique<DeviceMultigrid<Executor>>(run, problem, nx_, ny_, options_.links);
  for (int k = 0; k < history_length; ++k)
    past_.push_back({parallel::Array<double, Executor>(run), parallel::Array<double, Executor>(run)});
  group_potential_.emplace(run);
  next_potential_.emplace(run);
  body_result_.emplace(run);
  side_result_.emplace(run);
  size_ = problem.size;
}

template <class Executor>
void CutCell<Executor>::release_vectors() {
  if (!parallel::petsc_started()) return;
  if (basis_) VecDestroyVecs(history_length, &basis_);
  if (image_) VecDestroyVecs(history_length, &image_);
  krylov_.release();
}

template <class Executor>
PetscErrorCode multiply(Mat matrix, ::Vec x, ::Vec y) {
  CutCell<Executor>* solver = nullptr;
  PetscCall(MatShellGetContext(matrix, &solver));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayReadAndMemType(x, &from, nullptr));
  PetscCall(VecGetArrayWriteAndMemType(y, &to, nullptr));
  solver->multiply(from, to);
  PetscCall(VecRestoreArrayReadAndMemType(x, &from));
  PetscCall(VecRestoreArrayWriteAndMemType(y, &to));
  return 0;
}

template <class Executor>
PetscErrorCode precondition(PC pc, ::Vec r, ::Vec z) {
  CutCell<Executor>* solver = nullptr;
  PetscCall(PCShellGetContext(pc, &solver));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayReadAndMemType(r, &from, nullptr));
  PetscCall(VecGetArrayWriteAndMemType(z, &to, nullptr));
  solver->precondition(from, to);
  PetscCall(VecRestoreArrayReadAndMemType(r, &from));
  PetscCall(VecRestoreArrayWriteAndMemType(z, &to));
  return 0;
}

template <class Executor>
void CutCell<Executor>::prepare_system(const LaplaceProblem& problem) {
  const auto n =
      static_cast<PetscInt>(finest().view().layout.size() + static_cast<std::ptrdiff_t>(problem.groups.size()));
  PetscInt have = -1;
  if (krylov_.x) parallel::check_petsc(VecGetSize(krylov_.x, &have));
  groups_ = problem.groups.size();
  if (have != n) {
    release_vectors();
    parallel::check_petsc(VecCreate(PETSC_COMM_SELF, &krylov_.x));
    parallel::check_petsc(VecSetSizes(krylov_.x, n, n));
    parallel::check_petsc(VecSetType(krylov_.x, PetscSide<Executor>::vector_type));
    parallel::check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
    parallel::check_petsc(VecDuplicateVecs(krylov_.x, history_length, &basis_));
    parallel::check_petsc(VecDuplicateVecs(krylov_.x, history_length, &image_));
    parallel::check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, this, &krylov_.matrix));
    parallel::check_petsc(MatShellSetVecType(krylov_.matrix, PetscSide<Executor>::vector_type));
    parallel::check_petsc(
        MatShellSetOperation(krylov_.matrix, MATOP_MULT, reinterpret_cast<void (*)(void)>(device::multiply<Executor>)));
    parallel::check_petsc(KSPCreate(PETSC_COMM_SELF, &krylov_.ksp));
    PC pc = nullptr;
    parallel::check_petsc(KSPGetPC(krylov_.ksp, &pc));
    parallel::check_petsc(PCSetType(pc, PCSHELL));
    parallel::check_petsc(PCShellSetApply(pc, device::precondition<Executor>));
    parallel::check_petsc(PCShellSetContext(pc, this));
    parallel::check_petsc(PCShellSetName(pc, "cut-cell multigrid on the device"));
    const char* method = PetscSide<Executor>::method;
    register_conjugate_gradients<CutCell>(method);
    krylov_.set_options(options_.tolerance, method);
    krylov_.require_shell();
    PetscBool has_multigrid = PETSC_FALSE, is_fused = PETSC_FALSE;
    parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &has_multigrid));
    parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(krylov_.ksp), method, &is_fused));
    if (is_fused && !has_multigrid) parallel::check_petsc(KSPSetType(krylov_.ksp, KSPCG));
    PetscBool is_cpus = PETSC_FALSE;
    parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(krylov_.ksp), fused_cg, &is_cpus));
    if (is_cpus && !is_fused)
      throw InputError(std::string("-field_ksp_type ") + fused_cg + " is the CPU's: leave the option out on a device");
  }
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
  MatNullSpace space = nullptr;
  if (!problem.has_ground()) {
    ::Vec ones = nullptr;
    parallel::check_petsc(VecDuplicate(krylov_.x, &ones));
    {
      const WriteAccess value(ones);
      mark_unknowns(*run_, problem_->view(), finest().view(), static_cast<double*>(value));
    }
    parallel::check_petsc(VecNormalize(ones, nullptr));
    parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &space));
    parallel::check_petsc(VecDestroy(&ones));
  }
  krylov_.set_null_space(space);
  parallel::check_petsc(KSPSetUp(krylov_.ksp));
}

/// Also the unit of all potentials: single precision holds 38 decades either way, enough for any right-hand side of
/// about 1. It is kept while it is good enough, so that past solutions need no rescaling.
template <class Executor>
void CutCell<Executor>::make_right_hand_side() {
  parallel::check_petsc(VecSet(krylov_.b, 0.0));
  {
    const WriteAccess b(krylov_.b);
    right_hand_side(*run_, problem_->view(), finest().view(), static_cast<double*>(b));
  }
  double largest = 0;
  parallel::check_petsc(VecNorm(krylov_.b, NORM_INFINITY, &largest));
  const double ratio = largest / scale_;
  if (past_count_ == 0 || !(largest == 0 || (ratio > 1e-6 && ratio < 1e6))) {
    forget();
    scale_ = largest > 0 ? largest : 1;
  }
  parallel::check_petsc(VecScale(krylov_.b, 1 / scale_));
}

/// History::first_guess.
template <class Executor>
double CutCell<Executor>::first_guess() {
  parallel::check_petsc(VecSet(krylov_.x, 0.0));
  const int m = past_count_;
  if (m == 0) return 0.0;
  std::vector<double> gram(m * m), projection(m);
  for (int p = 0; p < m; ++p) {
    const WriteAccess v(basis_[p]), image(image_[p]);
    past_on_unknowns(*run_, problem_->view(), finest().view(), past_[p == 0 ? 0 : p - 1].view(),
                     p == 0 ? PastView{} : past_[p].view(), static_cast<double*>(v));
    multiply(v, image);
  }
  for (int p = 0; p < m; ++p) parallel::check_petsc(VecMDot(image_[p], m, basis_, &gram[p * m]));
  parallel::check_petsc(VecMDot(krylov_.b, m, basis_, projection.data()));
  const std::vector<double> alpha = closest_combination(gram, projection);
  parallel::check_petsc(VecMAXPY(krylov_.x, m, alpha.data(), basis_));
  double norm2 = 0;
  for (int p = 0; p < m; ++p) norm2 += alpha[p] * projection[p];
  return std::sqrt(std::max(0.0, norm2));
}

/// The groups' entries of x.
template <class Executor>
std::vector<double> CutCell<Executor>::group_unknowns() const {
  std::vector<double> value(groups_);
  const ReadAccess x(krylov_.x);
  if (groups_ > 0)
    run_->to_host(value.data(), static_cast<const double*>(x) + finest().view().layout.size(),
                  groups_ * sizeof(double));
  return value;
}

template <class Executor>
void CutCell<Executor>::finish_potentials(const LaplaceProblem& problem, LaplaceSolution& solution) {
  next_potential_->resize(groups_);
  const GridView& grid = finest().view();
  {
    const ReadAccess b(krylov_.b);
    const WriteAccess x(krylov_.x);
    balance_groups(*run_, problem_->view(), grid, static_cast<const double*>(b), static_cast<double*>(x),
                   finest().partial(), next_potential_->data());
  }
  std::vector<double> unknown = group_unknowns();
  if (!problem.has_ground()) {
    double mean = 0;
    for (const Body& body : problem.bodies) mean += unknown[body.group];
    mean /= static_cast<double>(std::max<std::size_t>(problem.bodies.size(), 1));
    {
      const WriteAccess x(krylov_.x);
      subtract(*run_, problem_->view(), grid, mean, static_cast<double*>(x));
    }
    unknown = group_unknowns();
  }
  solution.unknowns = finest().fluid_cells();
  solution.group_potential.resize(groups_);
  for (std::size_t g = 0; g < groups_; ++g) {
    solution.unknowns += problem.groups[g].floating;
    solution.group_potential[g] = problem.groups[g].floating ? scale_ * unknown[g] : problem.groups[g].potential;
  }
  group_potential_->upload(solution.group_potential);
}

template <class Executor>
void CutCell<Executor>::evaluate(const LaplaceProblem& problem, LaplaceSolution& solution) {
  body_result_->resize(bodies_);
  side_result_->resize(4 * side_parts);
  {
    const ReadAccess x(krylov_.x);
    const SolvedView solved{problem_->view(), finest().view(), x, scale_, group_potential_->data()};
    sum_bodies(*run_, solved, body_result_->data());
    sum_sides(*run_, solved, side_result_->data());
  }
  solution.energy = 0;
  solution.body_charge.clear();
  solution.body_force.clear();
  for (const BodyResult& body : body_result_->download()) {
    const std::size_t index = solution.body_charge.size();
    solution.energy += 0.5 * body.charge * solution.group_potential[problem.bodies[index].group];
    solution.body_charge.push_back(body.charge);
    solution.body_force.push_back({body.force_x, body.force_y});
  }
  const std::vector<SideResult> parts = side_result_->download();
  for (int side = 0; side < 4; ++side)
    for (int part = 0; part < side_parts; ++part) {
      solution.side_charge[side] += parts[side * side_parts + part].charge;
      solution.energy += parts[side * side_parts + part].energy;
    }
}

template <class Executor>
void CutCell<Executor>::keep() {
  std::rotate(past_.begin(), past_.end() - 1, past_.end());
  past_[0].cell.resize(finest().view().layout.size());
  past_[0].body.resize(bodies_);
  const ReadAccess x(krylov_.x);
  remember(*run_, problem_->view(), finest().view(), static_cast<const double*>(x), group_potential_->data(), scale_,
           past_[0].view());
  past_count_ = std::min(past_count_ + 1, history_length);
}

template <class Executor>
Profile CutCell<Executor>::profile(int repeats) {
  Profile profile;
  const WriteAccess r(krylov_.b), z(basis_[0]), y(image_[0]);
  const auto per_call = [&](auto f) {
    f();
    return run_->seconds([&] {
      for (int k = 0; k < repeats; ++k) f();
    }) / repeats;
  };
  const double cells = static_cast<double>(finest().view().layout.size());
  profile.apply_operator.seconds = per_call([&] { multiply(r, z); });
  // x and 1 / diagonal read, y written
  profile.apply_operator.bytes = cells * (8 + 4 + 8);
  profile.cycle.seconds = per_call([&] { precondition(r, z); });
  // A cell, half of the grid being red: the residual taken; f and 1 / diagonal to black; black and 1 / diagonal of red
  // to residual; residual to coarse f; f, 1 / diagonal and coarse v to black; black, f and 1 / diagonal of red to red.
  // Potentials of the finest grid are double. Coarser grids have a third of the cells together.
  const auto bytes = [](double v) {
    return (8 + v / 2) + (v / 2 + 2 + 2) + (2 + 1) + (8 + 1 + v / 2) + (v / 2 + 4 + v / 2);
  };
  profile.cycle.bytes = cells * (8 + 4 + bytes(8)) + cells / 3 * bytes(4);
  profile.copy.seconds = per_call([&] { run_->copy(y, z, static_cast<std::size_t>(cells) * sizeof(double)); });
  profile.copy.bytes = 16 * cells;
  profile.levels = multigrid_->levels();
  profile.coarse_unknowns = multigrid_->coarse_unknowns();
  forget();
  return profile;
}

}  // namespace lichtenberg::laplace::device
