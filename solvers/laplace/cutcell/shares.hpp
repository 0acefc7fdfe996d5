#pragma once

#include <map>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/processes.hpp"

namespace lichtenberg::laplace {

// Assembled systems are shared by all processes of a program: the first announces each solve to the others, which hold
// their rows of it (parallel::join_processes).
//
// (A program of one's own may as well let all its processes do the same: CutCellSolver::solve is collective over
// PETSC_COMM_WORLD then, and every process gets the solution.)

/// What another process than the first does with an announcement, its `take_part`.
class SolverShares {
 public:
  /// Throws whatever kept this process from its part, unless it is the problem's fault: then the first process knows
  /// too. After that it takes part in no further solve: throws Failure.
  void operator()(parallel::Message& announcement);

 private:
  void solve(int number, parallel::Message& announcement);
  std::map<int, CutCellSolver> solvers_;
  bool failed_ = false;
};

// What the first process tells the others; of no effect in a program that runs alone. Solvers go by number.
void announce_solve(int solver, const CutCellOptions& options, const LaplaceProblem& problem);
void announce_forgetting(int solver);
void announce_end(int solver);

}  // namespace lichtenberg::laplace
