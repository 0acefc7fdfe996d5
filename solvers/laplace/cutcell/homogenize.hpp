#pragma once

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

// Conductors that a coarse grid of the preconditioner does not resolve (medium.hpp).

namespace lichtenberg::laplace {

/// Chooses how a coarse grid of the preconditioner represents conductors. Small floating sets of bodies have no unknown
/// (`level.absorbed`). They become part of an effective medium, whose conductances contain their effect. Other bodies
/// that the grid does not resolve become subgrid conductors, represented by disks. `agglomerates`: sets of groups
/// (bodies with one potential) treated together; `finer`: the grid of cells half as large, or null. `bodies` must
/// contain the outlines and receives the choice.
void choose_unknowns(const LaplaceProblem& problem, const Agglomerates& agglomerates, const Level* finer,
                     GridBodies& bodies, Level& level);

/// Copies the finer grid's direct links (gap conductances) of subgrid conductors (bodies too small for this grid) to
/// `level.pairs`. This includes links that the elimination of near-surface cells (with a large conductance to a
/// conductor) has made. Links to conductors in the effective medium are left out. Conductors that nearly touch exchange
/// flux through their gap, not through cells, and conductances do not depend on the cell size.
void inherit_pairs(const LaplaceProblem& problem, const Level& finer, const GridBodies& bodies, Level& level);

/// Gives the fluid of a coarse grid the effective permittivity due to conductors that are part of the medium (Maxwell
/// Garnett). Computes the conductances of faces, and multiplies those of links to resolved bodies and to electrode
/// sides. Then computes the matrix diagonal again. If the grid resolves all bodies, it only clears `level.faces`.
void homogenize_fluid(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
