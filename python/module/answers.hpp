#pragma once

#include <pybind11/pybind11.h>

#include "src/scene/scene.hpp"

namespace lichtenberg::python {

/// Solves the field of a scene's initial state, for conductors or for charged grains. The interpreter lock is released
/// meanwhile. Returns a dictionary with the entries of `lichtenberg solve --json`, but arrays by quantity (position,
/// radius, group, potential, charge, force, and dipole of polarized grains) in place of the list of conductors.
/// Throws InputError and Failure.
pybind11::dict solve(const Scene& scene, bool capacitance, bool potential_field);

}  // namespace lichtenberg::python
