#pragma once

#include "solvers/laplace/cutcell/solver.hpp"
#include "src/field_methods/field_options.hpp"

namespace lichtenberg {

/// Converts the field options of a scene to options of the cut-cell solver (finite volumes), at the tolerance of a
/// single solve.
laplace::CutCellOptions cut_cell_options(const FieldOptions& options);

}  // namespace lichtenberg
