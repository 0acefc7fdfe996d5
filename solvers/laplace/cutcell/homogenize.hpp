#pragma once

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/grid_bodies.hpp"
#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

// Conductors that a coarse grid of the preconditioner does not resolve (medium.hpp).

namespace lichtenberg::laplace {

/// Chooses the bodies that the grid resolves, the groups that it absorbs (`level.absorbed`) and the subgrid conductors.
/// `finer`: the grid of cells half as large; null if there is none. `bodies` have their outlines.
void choose_unknowns(const LaplaceProblem& problem, const Agglomerates& agglomerates, const Level* finer,
                     GridBodies& bodies, Level& level);

/// Adds the finer grid's direct links of subgrid conductors, those through eliminated cells included. Conductors that
/// nearly touch exchange flux through their gap, not through cells, and conductances do not depend on the cell size.
void inherit_pairs(const LaplaceProblem& problem, const Level& finer, const GridBodies& bodies, Level& level);

/// Gives the fluid the effective permittivity of the absorbed conductors: multiplies the conductances of faces, links
/// and sides. Sets `level.faces`, which stay empty if the grid resolves all bodies.
void homogenize_fluid(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team);

}  // namespace lichtenberg::laplace
