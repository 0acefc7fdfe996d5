#pragma once

#include <petscksp.h>

#include "solvers/parallel/petsc.hpp"

// Access to the entries of PETSc's vectors in host or device memory.

namespace lichtenberg::laplace {

/// Write access to the entries of a PETSc vector, in host or device memory. The destructor returns the array to PETSc.
class WriteAccess {
 public:
  /// Requests the array of the vector's entries from PETSc. Throws Failure if PETSc reports an error.
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

/// Calls f(read, written) with the arrays of the PETSc vectors `from` (read only) and `to` (overwritten), in host or
/// device memory. Returns PETSc's error code.
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

/// Matrix and preconditioner given by functions, for PETSc's shell types MATSHELL and PCSHELL. They call multiply(x, y)
/// and precondition(r, z) of an object `work`.
struct Shell {
  void* work;
  /// Name of the preconditioner in PETSc's output.
  const char* name;
  /// PETSc type of the vectors, for instance VECSEQ.
  const char* vector_type;
  PetscErrorCode (*multiply)(Mat, ::Vec, ::Vec);
  PetscErrorCode (*precondition)(PC, ::Vec, ::Vec);

  /// Makes a Shell whose functions call work->multiply(x, y) and work->precondition(r, z). `name`: name of the
  /// preconditioner; `vector_type`: PETSc's type of the vectors. `work` must outlive the PETSc objects.
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
