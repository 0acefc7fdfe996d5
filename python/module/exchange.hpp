#pragma once

#include <pybind11/pybind11.h>

#include "src/scene/scene.hpp"

namespace lichtenberg::python {

/// Adds an effect to a scene of grains that transfers charge between grains in new contacts, as a Python function says.
/// The function takes an object with the attributes time, pair [n, 2] (indices), impact_speed [n], direction [n, d]
/// (unit vectors from the second grain to the first), and charge, radius and mass [n, 2]. It returns the charges [n]
/// that the first grains receive from the second ones. They are rounded to multiples of charge_quantum(unit), so that
/// the total charge is exact. Units are those of the scene. The caller has the interpreter lock. Throws InputError for
/// another kind of scene, or a unit that is not positive.
void add_charge_exchange(Scene& scene, pybind11::function function, double unit);

/// Adds the class of the function's argument to the module.
void register_contacts(pybind11::module_& module);

}  // namespace lichtenberg::python
