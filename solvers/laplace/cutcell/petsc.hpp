#pragma once

#include <petscksp.h>

#include <string>
#include <vector>

namespace lichtenberg::laplace {

/// Options for PETSc, verbatim as on its command line ("-field_pc_type", "gamg", ...). To be called before the first
/// field solver is made; PETSc itself starts with that one and never without it.
void set_petsc_options(std::vector<std::string> options);

/// Starts PETSc if it is not running (once a process). Throws Failure.
void start_petsc();

/// True once PETSc has been started in this process.
bool petsc_started();

/// Turns a PETSc error code into a Failure with PETSc's own message.
void check_petsc(PetscErrorCode code);

}  // namespace lichtenberg::laplace
