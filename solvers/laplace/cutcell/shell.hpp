#pragma once

#include <petscksp.h>

#include "solvers/parallel/petsc.hpp"

// The entries of PETSc's vectors, in memory of the host or of a device.

namespace lichtenberg::laplace {

/// Write access to a vector's entries for as long as this lives.
class WriteAccess {
 public:
  explicit WriteAccess(::Vec vector) : vector_(vector) {
    parallel::check_petsc(VecGetArrayAndMemType(vector_, &data_, nullptr));
  }
  WriteAccess(const WriteAccess&) = delete;
  WriteAccess& operator=(const WriteAccess&) = delete;
  ~WriteAccess() { VecRestoreArrayAndMemType(vector_, &data_); }
  operator double*() const { return data_; }

 private:
  ::Vec vector_;
  PetscScalar* data_ = nullptr;
};

/// f(the entries of `from`, those of `to`, which it writes).
template <class F>
PetscErrorCode with_memory(::Vec from, ::Vec to, F f) {
  const PetscScalar* read = nullptr;
  PetscScalar* written = nullptr;
  PetscCall(VecGetArrayReadAndMemType(from, &read, nullptr));
  PetscCall(VecGetArrayWriteAndMemType(to, &written, nullptr));
  f(read, written);
  PetscCall(VecRestoreArrayReadAndMemType(from, &read));
  PetscCall(VecRestoreArrayWriteAndMemType(to, &written));
  return 0;
}

/// A matrix and a preconditioner for PETSc that are functions: of a Work, multiply(x, y) and precondition(r, z).
struct Shell {
  void* work;
  const char* name;         ///< of the preconditioner
  const char* vector_type;  ///< of PETSc
  PetscErrorCode (*multiply)(Mat, ::Vec, ::Vec);
  PetscErrorCode (*precondition)(PC, ::Vec, ::Vec);

  template <class Work>
  static Shell of(Work* work, const char* name, const char* vector_type) {
    return {work, name, vector_type, multiply_by<Work>, precondition_by<Work>};
  }

 private:
  template <class Work>
  static PetscErrorCode multiply_by(Mat matrix, ::Vec x, ::Vec y) {
    Work* work = nullptr;
    PetscCall(MatShellGetContext(matrix, &work));
    return with_memory(x, y, [&](const double* from, double* to) { work->multiply(from, to); });
  }
  template <class Work>
  static PetscErrorCode precondition_by(PC pc, ::Vec r, ::Vec z) {
    Work* work = nullptr;
    PetscCall(PCShellGetContext(pc, &work));
    return with_memory(r, z, [&](const double* from, double* to) { work->precondition(from, to); });
  }
};

}  // namespace lichtenberg::laplace
