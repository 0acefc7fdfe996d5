#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/model/frame.hpp"

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

/// Returns a read-only numpy array of numbers that `owner` keeps alive, without a copy.
inline pybind11::array view_of(const std::vector<double>& numbers, std::vector<pybind11::ssize_t> shape,
                               pybind11::handle owner) {
  pybind11::array_t<double> view(std::move(shape), numbers.data(), owner);
  view.attr("flags").attr("writeable") = false;
  return view;
}

/// Returns the columns by name: for each, the pair of its array ([rows] or [rows, width]; a number for a system column)
/// and its unit.
pybind11::dict columns_of(Frame frame);

}  // namespace lichtenberg::python
