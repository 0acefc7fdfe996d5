#pragma once

#include <pybind11/pybind11.h>

#include <vector>

namespace lichtenberg::python {

/// Solves Smoluchowski's equation from single grains with a kernel that a Python function of two sizes returns
/// (theory::coagulation_series). Returns a dictionary with the arrays time, size, number and width up to the time at
/// which mass is lost, and the numbers error and lost. Throws InputError for a kernel that is negative or not finite,
/// wrong times or limits, and Failure if the solution fails.
pybind11::dict coagulate(const pybind11::function& kernel, const std::vector<double>& times, double tolerance,
                         double largest, bool stiff);

}  // namespace lichtenberg::python
