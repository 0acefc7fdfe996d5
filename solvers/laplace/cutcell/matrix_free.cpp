#include "solvers/laplace/cutcell/matrix_free.hpp"

#include <algorithm>

#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

PetscErrorCode multiply(Mat matrix, ::Vec x, ::Vec y) {
  MatrixFreeContext* context = nullptr;
  PetscCall(MatShellGetContext(matrix, &context));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  context->op->apply(from, to);
  ++context->applications;
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(VecRestoreArrayWrite(y, &to));
  return 0;
}

PetscErrorCode precondition(PC pc, ::Vec r, ::Vec z) {
  MatrixFreeContext* context = nullptr;
  PetscCall(PCShellGetContext(pc, &context));
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscCall(VecGetArrayRead(r, &from));
  PetscCall(VecGetArrayWrite(z, &to));
  context->multigrid->apply(from, to);
  PetscCall(VecRestoreArrayRead(r, &from));
  PetscCall(VecRestoreArrayWrite(z, &to));
  return 0;
}

/// 1 on every unknown; padding and covered cells are no unknowns.
MatNullSpace constants(const Level& level, const CutCellOperator& op) {
  ::Vec ones = nullptr;
  parallel::check_petsc(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(op.size()), &ones));
  PetscScalar* value = nullptr;
  parallel::check_petsc(VecGetArrayWrite(ones, &value));
  const std::size_t cells = level.layout.size();
  for (std::size_t k = 0; k < cells; ++k) value[k] = level.diagonal[k] > 0 ? 1.0 : 0.0;
  std::fill(value + cells, value + op.size(), 1.0);
  parallel::check_petsc(VecRestoreArrayWrite(ones, &value));
  parallel::check_petsc(VecNormalize(ones, nullptr));
  MatNullSpace space = nullptr;
  parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, 1, &ones, &space));
  parallel::check_petsc(VecDestroy(&ones));
  return space;
}

/// The fused method knows no other preconditioner than the multigrid.
void use_plain_cg_without_multigrid(KSP ksp) {
  PC pc = nullptr;
  PetscBool has_multigrid = PETSC_FALSE, is_fused = PETSC_FALSE;
  parallel::check_petsc(KSPGetPC(ksp, &pc));
  parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCSHELL, &has_multigrid));
  parallel::check_petsc(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), fused_cg, &is_fused));
  if (is_fused && !has_multigrid) parallel::check_petsc(KSPSetType(ksp, KSPCG));
}

/// Lends an array to a vector, also if what is done with it throws.
class PlacedArray {
 public:
  PlacedArray(::Vec vector, std::vector<double>& array) : vector_(vector) {
    parallel::check_petsc(VecPlaceArray(vector_, array.data()));
  }
  PlacedArray(const PlacedArray&) = delete;
  PlacedArray& operator=(const PlacedArray&) = delete;
  ~PlacedArray() { VecResetArray(vector_); }

 private:
  ::Vec vector_;
};

}  // namespace

MatrixFreeSystem::MatrixFreeSystem(LinkFormula links, double tolerance, parallel::Team& team)
    : links_(links), tolerance_(tolerance), team_(team), multigrid_(links, team) {}

void MatrixFreeSystem::build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  discretize(problem, level, op);
  context_.op = &op;
  context_.multigrid = &multigrid_;
  context_.null_space = !problem.has_ground();
  make_krylov(op);
  krylov_.set_null_space(context_.null_space ? constants(level, op) : nullptr);
}

/// The coarse grids know nothing of the operator: they are made beside it.
void MatrixFreeSystem::discretize(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  multigrid_.prepare(problem, level.layout);
  level.build(problem, links_, team_);
  multigrid_.build_coarse(problem, level);
  op.build(problem, level, team_);
  multigrid_.build_finest(problem, level);
}

void MatrixFreeSystem::make_krylov(CutCellOperator& op) {
  const auto n = static_cast<PetscInt>(op.size());
  PetscInt have = -1;
  if (krylov_.x) parallel::check_petsc(VecGetSize(krylov_.x, &have));
  if (have != n) make_vectors(n);
  if (!krylov_.ksp) {
    parallel::check_petsc(KSPCreate(PETSC_COMM_SELF, &krylov_.ksp));
    PC pc = nullptr;
    parallel::check_petsc(KSPGetPC(krylov_.ksp, &pc));
    parallel::check_petsc(PCSetType(pc, PCSHELL));
    parallel::check_petsc(PCShellSetApply(pc, precondition));
    parallel::check_petsc(PCShellSetApplyTranspose(pc, precondition));  // symmetric, as the matrix
    parallel::check_petsc(PCShellSetContext(pc, &context_));
    parallel::check_petsc(PCShellSetName(pc, "cut-cell multigrid"));
    krylov_.set_options(tolerance_, fused_cg);
    krylov_.require_shell();
    use_plain_cg_without_multigrid(krylov_.ksp);
  }
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
}

/// Anew each time that groups merge or part. What options have said of the method stays.
void MatrixFreeSystem::make_vectors(PetscInt n) {
  if (krylov_.ksp) parallel::check_petsc(KSPReset(krylov_.ksp));
  parallel::check_petsc(MatDestroy(&krylov_.matrix));
  for (::Vec* vector : {&krylov_.x, &krylov_.b}) {
    parallel::check_petsc(VecDestroy(vector));
    parallel::check_petsc(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, nullptr, vector));
  }
  parallel::check_petsc(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &context_, &krylov_.matrix));
  for (const MatOperation operation : {MATOP_MULT, MATOP_MULT_TRANSPOSE})
    parallel::check_petsc(MatShellSetOperation(krylov_.matrix, operation, reinterpret_cast<void (*)()>(multiply)));
}

void MatrixFreeSystem::solve(std::vector<double>& b, std::vector<double>& x, std::vector<double>& residual,
                             const StopCriterion& criterion, LaplaceSolution& solution) {
  const PlacedArray to(krylov_.x, x), from(krylov_.b, b);
  krylov_.criterion = criterion;
  context_.applications = 0;
  std::swap(context_.r, residual);
  krylov_.solve(solution);
  std::swap(context_.r, residual);
  solution.work += context_.applications + multigrid_.take_work();
}

void MatrixFreeSystem::first_guess(const LaplaceProblem& problem, double scale, std::vector<double>& x) {
  LinearSystem::first_guess(problem, scale, x);
  multigrid_.nested_guess(problem, scale, x.data());
}

}  // namespace lichtenberg::laplace
