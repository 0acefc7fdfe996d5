#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

namespace lichtenberg::parallel {

/// Options for PETSc, verbatim as on its command line ("-field_pc_type", "gamg", ...). To be called before the first
/// solver that uses it is made; PETSc itself starts with that one and never without it.
void set_petsc_options(std::vector<std::string> options);

/// Starts PETSc if it is not running (once a process). Throws Failure.
void start_petsc();

/// Ends PETSc, which else ends with the process. A program that has used a CUDA device must call this before main
/// returns, when its solvers are gone: in an exit handler PETSc 3.22 aborts over its memory on the device.
void finish_petsc();

/// True once PETSc has been started in this process.
bool petsc_started();

/// This process's number among those that mpirun started, from 0, and how many they are (0 and 1 before PETSc runs).
int process_rank();
int process_count();

/// Returns the options of `set_petsc_options` that nothing has asked for yet: all of them before PETSc runs.
std::vector<std::string> unused_petsc_options();

/// Turns a PETSc error code into a Failure with PETSc's own message.
void check_petsc(PetscErrorCode code);

}  // namespace lichtenberg::parallel
