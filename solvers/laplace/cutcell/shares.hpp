#pragma once

#include <map>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/processes.hpp"

namespace lichtenberg::laplace {

// All processes of a program share a field solve. The first announces each solve, and the others hold their rows of the
// grids or of the assembled system (parallel::join_processes).
//
// In other programs all processes may call CutCellSolver::solve, which is collective over PETSC_COMM_WORLD; every
// process gets the solution.

/// Message handler of all MPI processes except the first, for field solvers (`handle_message` of join_processes).
/// It takes part in each collective operation that the first process announces, with one CutCellSolver for each of its
/// solvers.
class SolverShares {
 public:
  /// Executes one announced operation: a solve, forgetting the history, following a
  /// coarser solver, gathering the field, or the end of a solver. Throws the exception
  /// that stopped this process's part, except InputError, which the first process throws as well. Throws Failure for a
  /// solve after such an exception.
  void operator()(parallel::Message& announcement);

 private:
  void solve(int number, parallel::Message& announcement);
  void follow(int number, parallel::Message& announcement);
  std::map<int, CutCellSolver> solvers_;
  bool failed_ = false;
};

// Announcements of the first process; without effect in a program of one process. Solvers are numbered.
void announce_solve(int solver, const CutCellOptions& options, const LaplaceProblem& problem);
void announce_forgetting(int solver);
void announce_following(int solver, const CutCellOptions& options, int coarser, const CutCellOptions& coarser_options);
void announce_gathering(int solver);
void announce_end(int solver);

}  // namespace lichtenberg::laplace
