#pragma once

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

// Conductors that a coarse grid of the preconditioner does not resolve (medium.hpp).

namespace lichtenberg::laplace {

/// Chooses the unknowns of a coarse grid: the bodies that it resolves, and the groups (bodies with one potential) that
/// its medium absorbs (`level.absorbed`). The remaining small disks become subgrid conductors (disks too small for the
/// grid). `agglomerates`: sets of groups treated together; `finer`: the grid of cells half as large, or null. `bodies`
/// must have their outlines; it receives the choice.
void choose_unknowns(const LaplaceProblem& problem, const Agglomerates& agglomerates, const Level* finer,
                     GridBodies& bodies, Level& level);

/// Copies the finer grid's direct links (gap conductances) of subgrid conductors, disks too small for this grid, to
/// `level.pairs`. Links that the elimination of near-surface cells (dominated by a conductor) has made are included.
/// Conductors that nearly touch exchange flux through their gap, not through cells, and conductances do not depend on
/// the cell size.
void inherit_pairs(const LaplaceProblem& problem, const Level& finer, const GridBodies& bodies, Level& level);

/// Gives the fluid the effective permittivity of the absorbed conductors (Maxwell Garnett). Multiplies the conductances
/// of faces, links and electrode sides, and computes the diagonal again. `level.faces` stays empty if the grid resolves
/// all bodies.
void homogenize_fluid(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
