#include "solvers/laplace/cutcell/matrix_free.hpp"

#include <algorithm>
#include <future>
#include <thread>

#include "solvers/laplace/cutcell/petsc.hpp"

namespace lichtenberg::laplace {

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

/// 1 on every unknown; padding and covered cells are no unknowns.
MatNullSpace constants(const Level& level, const CutCellOperator& op) {
  Vec ones = nullptr;
  check_petsc(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(op.size()), &ones));
  PetscScalar* value = nullptr;
  check_petsc(VecGetArrayWrite(ones, &value));
  const std::size_t cells = level.layout.size();
  for (std::size_t k = 0; k < cells; ++k) value[k] = level.diagonal[k] > 0 ? 1.0 : 0.0;
  std::fill(value + cells, value + op.size(), 1.0);
  check_petsc(VecRestoreArrayWrite(ones, &value));
  check_petsc(VecNormalize(ones, nullptr));
  MatNullSpace space = nullptr;
  check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &space));
  check_petsc(VecDestroy(&ones));
  return space;
}

/// Lends an array to a vector, also if what is done with it throws.
class PlacedArray {
 public:
  PlacedArray(Vec vector, std::vector<double>& array) : vector_(vector) {
    check_petsc(VecPlaceArray(vector_, array.data()));
  }
  PlacedArray(const PlacedArray&) = delete;
  PlacedArray& operator=(const PlacedArray&) = delete;
  ~PlacedArray() { VecResetArray(vector_); }

 private:
  Vec vector_;
};

}  // namespace

MatrixFreeSystem::MatrixFreeSystem(LinkFormula links, double tolerance)
    : links_(links), tolerance_(tolerance), multigrid_(links) {}

void MatrixFreeSystem::build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  discretize(problem, level, op);
  make_krylov(op);
  krylov_.set_null_space(problem.has_ground() ? nullptr : constants(level, op));
  check_petsc(KSPSetUp(krylov_.ksp));
}

/// The coarser grids know nothing of the finest: they are made beside it, on another core if there is one.
void MatrixFreeSystem::discretize(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  multigrid_.prepare(problem, level.layout);
  const auto policy = std::thread::hardware_concurrency() > 1 ? std::launch::async : std::launch::deferred;
  std::future<void> coarser = std::async(policy, [&] { multigrid_.build_coarse(problem); });
  level.build(problem, links_);
  op.build(problem, level);
  multigrid_.build_finest(problem, level);
  coarser.get();
}

void MatrixFreeSystem::make_krylov(CutCellOperator& op) {
  const auto n = static_cast<PetscInt>(op.size());
  PetscInt have = -1;
  if (krylov_.x) check_petsc(VecGetSize(krylov_.x, &have));
  if (have != n) {
    krylov_.release();
    check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, nullptr, &krylov_.x));
    check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
    check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &op, &krylov_.matrix));
    check_petsc(MatShellSetOperation(krylov_.matrix, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
    check_petsc(KSPCreate(PETSC_COMM_SELF, &krylov_.ksp));
    PC pc = nullptr;
    check_petsc(KSPGetPC(krylov_.ksp, &pc));
    check_petsc(PCSetType(pc, PCSHELL));
    check_petsc(PCShellSetApply(pc, precondition));
    check_petsc(PCShellSetContext(pc, &multigrid_));
    check_petsc(PCShellSetName(pc, "cut-cell multigrid"));
    krylov_.set_options(tolerance_);
    krylov_.require_shell();
  }
  check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
}

void MatrixFreeSystem::solve(std::vector<double>& b, std::vector<double>& x, const StopCriterion& criterion,
                             LaplaceSolution& solution) {
  const PlacedArray to(krylov_.x, x), from(krylov_.b, b);
  krylov_.criterion = criterion;
  krylov_.solve(solution);
}

}  // namespace lichtenberg::laplace
