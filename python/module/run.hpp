#pragma once

#include <pybind11/pybind11.h>

namespace lichtenberg::python {

/// Adds the class Run, which advances a scene from frame to frame, to the module.
void register_run(pybind11::module_& module);

}  // namespace lichtenberg::python
