#pragma once

#include <pybind11/numpy.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "solvers/stop.hpp"

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
std::recursive_timed_mutex& solver_mutex();

/// Calls work() without the interpreter lock, and alone among all solves and runs of the process.
template <class Work>
auto compute(const Work& work) {
  const pybind11::gil_scoped_release unlocked;
  const std::lock_guard lock(solver_mutex());
  return work();
}

/// Calls work() as compute() does. A signal of the keyboard ends the wait for other solves and the field solves of
/// work(); Python's KeyboardInterrupt is then thrown.
template <class Work>
auto compute_until_interrupt(const Work& work) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds check_interval{50};
  std::optional<pybind11::error_already_set> interruption;
  Clock::time_point last = Clock::now();
  const auto is_interrupted = [&] {
    if (interruption) return true;
    if (Clock::now() - last < check_interval) return false;
    last = Clock::now();
    const pybind11::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) interruption.emplace();  // takes the exception
    return interruption.has_value();
  };
  try {
    const pybind11::gil_scoped_release unlocked;
    std::unique_lock lock(solver_mutex(), std::defer_lock);
    while (!lock.try_lock_for(check_interval))
      if (is_interrupted()) throw Stopped{};
    const StopRequestScope scope(is_interrupted);
    return work();
  } catch (const Stopped&) {
    throw std::move(*interruption);
  }
}

}  // namespace lichtenberg::python
