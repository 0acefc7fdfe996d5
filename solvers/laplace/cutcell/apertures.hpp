#pragma once

// LinkFormula::aperture, the obvious cut cell, kept to compare with. Every cell with some fluid in it has a balance;
// faces conduct as far as they are open; the surface in a cell takes its length times the normal derivative, for which
// there is only (potential of the cell - potential of the body) / (distance of the cell's centre to the surface).
// First-order: that potential is the one at the centre, wherever the cell's fluid is. Capacitance of two disks at d/2R
// = 2: off by 3.4, 1.6, 0.76 % at R = 4, 8, 16 cells. Forces are the pressure eps/2 (dV/dn)^2 summed over the surface,
// since conductances of this kind have no derivative that would mean one: off by 5 to 10 % whatever the grid, for dV/dn
// is wrong by a share of itself in every cell.

#include "solvers/laplace/cutcell/level.hpp"

namespace lichtenberg::laplace {

/// Discretizes the problem on the level, whose `cover` then names cells without any fluid only. Throws InputError for a
/// body that is not round.
void build_by_apertures(const LaplaceProblem& problem, Level& level);

}  // namespace lichtenberg::laplace
