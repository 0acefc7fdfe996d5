#include "solvers/laplace/cutcell/assembled.hpp"

#include "solvers/laplace/cutcell/system.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

AssembledSystem::AssembledSystem(LinkFormula links, double tolerance, CutCellOptions::Device device)
    : links_(links), tolerance_(tolerance), device_(device) {}

void AssembledSystem::build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  builder_.build(problem, links_, level);
  op.build(problem, level);
  assemble_matrix(problem, level);
  set_up_preconditioner(problem);
}

void AssembledSystem::assemble_matrix(const LaplaceProblem& problem, const Level& level) {
  krylov_.release();
  SparseSystem system = number_unknowns(problem, level);
  const PetscInt n = system.unknowns();
  PetscInt own = PETSC_DECIDE, all = n, end = 0;
  parallel::check_petsc(PetscSplitOwnership(PETSC_COMM_WORLD, &own, &all));
  parallel::check_petsc(MPI_Scan(&own, &end, 1, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD));
  assemble_rows(problem, level, static_cast<int>(end - own), static_cast<int>(end), system);

  Mat& matrix = krylov_.matrix;
  parallel::check_petsc(MatCreate(PETSC_COMM_WORLD, &matrix));
  parallel::check_petsc(MatSetSizes(matrix, own, own, n, n));
  parallel::check_petsc(MatSetOptionsPrefix(matrix, "field_"));
  parallel::check_petsc(MatSetType(matrix, device_ == CutCellOptions::Device::cuda ? MATAIJCUSPARSE : MATAIJ));
  parallel::check_petsc(MatSetFromOptions(matrix));
  // Only the call that fits the number of processes has an effect.
  parallel::check_petsc(
      MatSeqAIJSetPreallocationCSR(matrix, system.start.data(), system.index.data(), system.value.data()));
  parallel::check_petsc(
      MatMPIAIJSetPreallocationCSR(matrix, system.start.data(), system.index.data(), system.value.data()));
  parallel::check_petsc(MatSetOption(matrix, MAT_SPD, PETSC_TRUE));

  parallel::check_petsc(MatCreateVecs(matrix, &krylov_.x, nullptr));
  parallel::check_petsc(VecSetOptionsPrefix(krylov_.x, "field_"));
  parallel::check_petsc(VecSetFromOptions(krylov_.x));
  parallel::check_petsc(VecDuplicate(krylov_.x, &krylov_.b));
  entry_ = std::move(system.slot);
  for (const int g : system.group) entry_.push_back(level.layout.size() + g);
  numbering_ = {};
  numbering_.differences = std::move(system.differences);
}

void AssembledSystem::set_up_preconditioner(const LaplaceProblem& problem) {
  parallel::check_petsc(KSPCreate(PETSC_COMM_WORLD, &krylov_.ksp));
  PC pc = nullptr;
  parallel::check_petsc(KSPGetPC(krylov_.ksp, &pc));
  parallel::check_petsc(PCSetType(pc, PCGAMG));
  krylov_.set_options(tolerance_);
  parallel::check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
  MatNullSpace constants = nullptr;
  if (!problem.has_ground()) constants = constant_potential();
  krylov_.set_null_space(constants);
  parallel::check_petsc(KSPSetUp(krylov_.ksp));
}

void AssembledSystem::solve(std::vector<double>& b, std::vector<double>& x, SplitVector&,
                            const StopCriterion& criterion, LaplaceSolution& solution) {
  std::vector<double> unknowns = by_unknown(x), charges = by_unknown(b);
  numbering_.from_potentials(unknowns.data());
  numbering_.from_charges(charges.data());
  scatter(unknowns, krylov_.x);
  scatter(charges, krylov_.b);
  krylov_.criterion = criterion;
  krylov_.solve(solution);
  solution.work = 0;  // not counted: the work of PETSc's preconditioners is unknown
  gather(krylov_.x, x);
}

std::vector<double> AssembledSystem::by_unknown(const std::vector<double>& x) const {
  std::vector<double> result;
  result.reserve(entry_.size());
  for (const std::ptrdiff_t entry : entry_) result.push_back(x[entry]);
  return result;
}

/// Returns the null space of the matrix: the same potential everywhere, which is zero for unknowns that are
/// differences.
MatNullSpace AssembledSystem::constant_potential() const {
  MatNullSpace space = nullptr;
  if (numbering_.differences.empty()) {
    parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_TRUE, 0, nullptr, &space));
    return space;
  }
  std::vector<double> same(entry_.size(), 1.0);
  numbering_.from_potentials(same.data());
  ::Vec constant = nullptr;
  parallel::check_petsc(VecDuplicate(krylov_.x, &constant));
  scatter(same, constant);
  parallel::check_petsc(VecNormalize(constant, nullptr));
  parallel::check_petsc(MatNullSpaceCreate(PETSC_COMM_WORLD, PETSC_FALSE, 1, &constant, &space));
  parallel::check_petsc(VecDestroy(&constant));
  return space;
}

/// Copies the matrix rows that this process owns from a vector by unknown to a PETSc vector.
void AssembledSystem::scatter(const std::vector<double>& by_unknown, ::Vec to) const {
  PetscInt begin = 0, end = 0;
  parallel::check_petsc(VecGetOwnershipRange(to, &begin, &end));
  PetscScalar* value = nullptr;
  parallel::check_petsc(VecGetArrayWrite(to, &value));
  for (PetscInt row = begin; row < end; ++row) value[row - begin] = by_unknown[row];
  parallel::check_petsc(VecRestoreArrayWrite(to, &value));
}

/// Copies all rows of a PETSc vector to each process, as potentials in the operator's layout.
void AssembledSystem::gather(::Vec from, std::vector<double>& to) const {
  VecScatter all_of = nullptr;
  ::Vec all = nullptr;
  parallel::check_petsc(VecScatterCreateToAll(from, &all_of, &all));
  parallel::check_petsc(VecScatterBegin(all_of, from, all, INSERT_VALUES, SCATTER_FORWARD));
  parallel::check_petsc(VecScatterEnd(all_of, from, all, INSERT_VALUES, SCATTER_FORWARD));
  const PetscScalar* value = nullptr;
  parallel::check_petsc(VecGetArrayRead(all, &value));
  std::vector<double> unknowns(value, value + entry_.size());
  numbering_.to_potentials(unknowns.data());
  for (std::size_t row = 0; row < entry_.size(); ++row) to[entry_[row]] = unknowns[row];
  parallel::check_petsc(VecRestoreArrayRead(all, &value));
  parallel::check_petsc(VecScatterDestroy(&all_of));
  parallel::check_petsc(VecDestroy(&all));
}

}  // namespace lichtenberg::laplace
