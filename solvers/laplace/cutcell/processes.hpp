#pragma once

#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace {

// A program under mpirun: the first process runs it; the others hold their share of the assembled systems that it
// solves and do nothing else. They read no scene, print nothing, write no file, and decide nothing.
//
// (A program of one's own may as well let all its processes do the same: CutCellSolver::solve is collective over
// PETSC_COMM_WORLD then, and every process gets the solution.)

/// To be called at the start of a program. Started alone (told from the launcher's environment, without touching MPI)
/// it does nothing and returns true. Otherwise it starts PETSc and returns true in the first process, and in the others
/// only when the first has dismissed them: false, and nothing is left to do but to exit. Throws InputError if PETSc was
/// built without MPI.
bool join_processes();

/// Ends the others' part; after an error, whatever state it has left them in. Of no effect in a program that runs
/// alone.
void dismiss_processes(bool after_error);

// What the first process tells the others; of no effect in a program that runs alone. Solvers go by number.
void announce_solve(int solver, const CutCellOptions& options, const LaplaceProblem& problem);
void announce_forgetting(int solver);
void announce_end(int solver);

}  // namespace lichtenberg::laplace
