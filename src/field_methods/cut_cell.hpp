#pragma once

#include "solvers/laplace/cutcell/solver.hpp"
#include "src/field_methods/field_options.hpp"

namespace lichtenberg {

/// Options of the cut-cell method, at the tolerance of a single solve.
laplace::CutCellOptions cut_cell_options(const FieldOptions& options);

}  // namespace lichtenberg
