#include "solvers/laplace/cutcell/matrix_free.hpp"

#include <algorithm>

#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

/// Gives a PETSc vector the memory of an array; the destructor takes it back.
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
  if (!context_.null_space) return krylov_.set_null_space(nullptr);
  krylov_.set_constant_null_space([&](double* value) {  // zero for padding and covered cells
    for (std::size_t k = 0; k < op.cells(); ++k) value[k] = level.diagonal[k] > 0 ? 1.0 : 0.0;
    std::fill(value + op.cells(), value + op.size(), 1.0);
  });
}

/// Discretizes all grids. The coarse grids do not depend on the operator and may be built at the same time.
void MatrixFreeSystem::discretize(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  multigrid_.prepare(problem, level.layout);
  builder_.build(problem, links_, level, team_);
  multigrid_.build_coarse(problem, level);
  op.build(problem, level, team_);
  multigrid_.build_finest(problem, level);
}

void MatrixFreeSystem::make_krylov(CutCellOperator& op) {
  const auto n = static_cast<PetscInt>(op.size());
  PetscInt have = -1;
  if (krylov_.x) parallel::check_petsc(VecGetLocalSize(krylov_.x, &have));
  if (have != n) make_vectors(n);
  if (!krylov_.ksp) krylov_.make_shell_method(shell(), tolerance_, fused_cg);
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
}

/// Makes PETSc's vectors and matrix for n entries, after a change of the number of groups. The method keeps its
/// options.
void MatrixFreeSystem::make_vectors(PetscInt n) {
  if (krylov_.ksp) parallel::check_petsc(KSPReset(krylov_.ksp));
  parallel::check_petsc(MatDestroy(&krylov_.matrix));
  for (::Vec* vector : {&krylov_.x, &krylov_.b}) {
    parallel::check_petsc(VecDestroy(vector));
    if (parallel::process_count() == 1)
      parallel::check_petsc(VecCreateSeqWithArray(PETSC_COMM_WORLD, 1, n, nullptr, vector));
    else
      parallel::check_petsc(VecCreateMPIWithArray(PETSC_COMM_WORLD, 1, n, PETSC_DETERMINE, nullptr, vector));
  }
  krylov_.make_shell_matrix(shell(), n);
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
