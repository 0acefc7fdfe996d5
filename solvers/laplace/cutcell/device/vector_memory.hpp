#pragma once

#include <petscvec.h>

#include "solvers/parallel/petsc.hpp"

// Where PETSc's vectors have their numbers on the device.

namespace lichtenberg::laplace::device {

/// Vec's memory on the device for as long as this lives.
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

/// f(the numbers of `from`, those of `to`, which it writes).
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

}  // namespace lichtenberg::laplace::device
