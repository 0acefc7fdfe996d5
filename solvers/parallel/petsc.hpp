#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

namespace lichtenberg::parallel {

/// Sets the options with which PETSc will start, as words of its command line ("-field_pc_type", "gamg", ...). Must be
/// called before start_petsc(), which join_processes() and solvers that use PETSc call.
void set_petsc_options(std::vector<std::string> options);

/// Starts the library PETSc with the options of set_petsc_options(), unless it is already running. Also limits
/// OpenBLAS, if it is loaded, to one thread. Throws Failure if PETSc cannot start.
void start_petsc();

/// Finalizes PETSc if it is running. Without this call an exit handler of the process finalizes it. A program that has
/// used a CUDA device must call this function before main returns, after its solvers are destroyed. In an exit handler
/// PETSc 3.22 aborts because of its memory on the device.
void finish_petsc();

/// Returns true if PETSc is initialized in this process.
bool petsc_started();

/// Returns the MPI rank of this process: its number, from 0, among the processes that mpirun started. 0 before PETSc
/// runs.
int process_rank();
/// Returns the number of MPI processes that mpirun started; 1 before PETSc runs.
int process_count();

/// Returns the names of the options of `set_petsc_options` that PETSc has not read yet, to report misspelt ones; all
/// names before PETSc runs. Options that start with "-options_" are excluded, because PETSc reads them when it is
/// finalized.
std::vector<std::string> unused_petsc_options();

/// Throws Failure with PETSc's error message if a PETSc call returned an error code other than 0.
void check_petsc(PetscErrorCode code);

}  // namespace lichtenberg::parallel
