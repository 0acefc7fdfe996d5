#pragma once

#include <pybind11/pybind11.h>

#include "src/scene/scene.hpp"

namespace lichtenberg::python {

/// Adds an effect to the scene whose forces a Python function returns. The function takes an object with the attributes
/// time, position [N, d], momentum [N, d], mass [N], radius [N] and charge [N] (None without charges). It returns
/// forces [N, d], or a pair of forces and their potential energy. Units are those of the scene. The caller has the
/// interpreter lock. Exceptions of the function end the step that called it.
void add_force(Scene& scene, pybind11::function function);

/// Adds the class of the function's argument to the module.
void register_state(pybind11::module_& module);

}  // namespace lichtenberg::python
