#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace lichtenberg::python {

/// Returns a numpy array that owns the numbers, without a copy. `shape`: its dimensions.
template <class Number>
pybind11::array array_of(std::vector<Number> numbers, std::vector<pybind11::ssize_t> shape) {
  auto owner = std::make_unique<std::vector<Number>>(std::move(numbers));
  const Number* data = owner->data();
  pybind11::capsule capsule(owner.get(), [](void* pointer) { delete static_cast<std::vector<Number>*>(pointer); });
  owner.release();  // the capsule deletes it
  return pybind11::array_t<Number>(std::move(shape), data, std::move(capsule));
}

/// Mutex of all solves and runs, which share the state of PETSc and the planner of FFTW. It is recursive, because a
/// force function of a run may solve a field. Lock it without the interpreter lock only; otherwise two threads may wait
/// for each other.
std::recursive_mutex& solver_mutex();

/// Calls work() without the interpreter lock, and alone among all solves and runs of the process.
template <class Work>
auto compute(const Work& work) {
  const pybind11::gil_scoped_release unlocked;
  const std::lock_guard lock(solver_mutex());
  return work();
}

}  // namespace lichtenberg::python
