#pragma once

#include <petscksp.h>

#include "solvers/parallel/petsc.hpp"

// Access to the entries of PETSc's vectors in host or device memory.

namespace lichtenberg::laplace {

/// Write access to a vector's entries during its lifetime.
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

/// Calls f with the entries of `from` and of `to`; f writes those of `to`.
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

/// Matrix and preconditioner for PETSc as functions: multiply(x, y) and precondition(r, z) of a Work object.
struct Shell {
  void* work;
  /// Name of the preconditioner.
  const char* name;
  /// PETSc's vector type.
  const char* vector_type;
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
