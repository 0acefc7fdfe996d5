#include "solvers/laplace/cutcell/assembled.hpp"

#include "solvers/laplace/cutcell/petsc.hpp"

namespace lichtenberg::laplace {

AssembledSystem::AssembledSystem(LinkFormula links, double tolerance) : links_(links), tolerance_(tolerance) {}

void AssembledSystem::build(const LaplaceProblem& problem, Level& level, CutCellOperator& op) {
  level.build(problem, links_);
  op.build(problem, level);
  krylov_.release();
  cells_ = level.layout.size();
  sparse_ = assemble(problem, level, false, false);
  make_krylov();
  MatNullSpace constants = nullptr;
  if (!problem.has_ground()) check_petsc(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_TRUE, 0, nullptr, &constants));
  krylov_.set_null_space(constants);
  check_petsc(KSPSetUp(krylov_.ksp));
}

void AssembledSystem::make_krylov() {
  const auto n = static_cast<PetscInt>(sparse_.unknowns());
  check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, sparse_.start.data(), sparse_.index.data(),
                                        sparse_.value.data(), &krylov_.matrix));
  check_petsc(MatSetOption(krylov_.matrix, MAT_SPD, PETSC_TRUE));
  check_petsc(MatCreateVecs(krylov_.matrix, &krylov_.x, &krylov_.b));
  check_petsc(KSPCreate(PETSC_COMM_SELF, &krylov_.ksp));
  PC pc = nullptr;
  check_petsc(KSPGetPC(krylov_.ksp, &pc));
  check_petsc(PCSetType(pc, PCGAMG));
  krylov_.set_options(tolerance_);
  check_petsc(KSPSetOperators(krylov_.ksp, krylov_.matrix, krylov_.matrix));
}

void AssembledSystem::solve(std::vector<double>& b, std::vector<double>& x, const StopCriterion& criterion,
                            LaplaceSolution& solution) {
  scatter(x, krylov_.x);
  scatter(b, krylov_.b);
  krylov_.criterion = criterion;
  krylov_.solve(solution);
  gather(krylov_.x, x);
}

void AssembledSystem::scatter(const std::vector<double>& from, Vec to) const {
  PetscScalar* value = nullptr;
  check_petsc(VecGetArrayWrite(to, &value));
  for (std::size_t a = 0; a < sparse_.slot.size(); ++a) value[a] = from[sparse_.slot[a]];
  for (std::size_t g = 0; g < sparse_.group.size(); ++g)
    value[sparse_.slot.size() + g] = from[cells_ + sparse_.group[g]];
  check_petsc(VecRestoreArrayWrite(to, &value));
}

void AssembledSystem::gather(Vec from, std::vector<double>& to) const {
  const PetscScalar* value = nullptr;
  check_petsc(VecGetArrayRead(from, &value));
  for (std::size_t a = 0; a < sparse_.slot.size(); ++a) to[sparse_.slot[a]] = value[a];
  for (std::size_t g = 0; g < sparse_.group.size(); ++g) to[cells_ + sparse_.group[g]] = value[sparse_.slot.size() + g];
  check_petsc(VecRestoreArrayRead(from, &value));
}

}  // namespace lichtenberg::laplace
