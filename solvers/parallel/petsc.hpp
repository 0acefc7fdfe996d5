#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

namespace lichtenberg::parallel {

/// Sets options for PETSc, verbatim as on its command line ("-field_pc_type", "gamg", ...). Must be called before the
/// first solver that uses PETSc is made; PETSc starts with that solver only.
void set_petsc_options(std::vector<std::string> options);

/// Starts PETSc if it is not running (once per process). Throws Failure if PETSc cannot start.
void start_petsc();

/// Ends PETSc, which otherwise ends with the process. A program that has used a CUDA device must call this before main
/// returns, after its solvers are destroyed. In an exit handler PETSc 3.22 aborts because of its memory on the device.
void finish_petsc();

/// Returns true once PETSc has been started in this process.
bool petsc_started();

/// Returns this process's number, from 0, among those that mpirun started; 0 before PETSc runs.
int process_rank();
/// Returns the number of processes that mpirun started; 1 before PETSc runs.
int process_count();

/// Returns the options of `set_petsc_options` that have not been read yet: all of them before PETSc runs.
std::vector<std::string> unused_petsc_options();

/// Converts a PETSc error code into a Failure with PETSc's own message.
void check_petsc(PetscErrorCode code);

}  // namespace lichtenberg::parallel
