#pragma once

// LinkFormula::aperture, the textbook cut-cell discretization, for comparison. Every cell that contains fluid has a
// balance. Faces conduct in proportion to their open length. The surface in a cell contributes its length times the
// normal derivative. The latter is approximated by (potential of the cell - potential of the body) / d, with d the
// distance of the cell's centre to the surface. This is first-order, because the cell's potential is taken at its
// centre, wherever its fluid is. The derivatives of these conductances are meaningless, so that the force is the sum of
// the pressure eps/2 (dV/dn)^2 over the surface. Its error does not decrease with the grid, because dV/dn has a
// relative error in every cell. Both errors are in docs/measurements/cutcell.json.

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Discretizes the problem on one grid by textbook cut cells with open fractions of faces (apertures). Sets cell
/// owners, diagonals, face conductances and links of `level`. A cell is covered if none of its faces is open and its
/// centre lies in a body. Throws InputError for a body that is not round.
void build_by_apertures(const LaplaceProblem& problem, Level& level);

}  // namespace lichtenberg::laplace
