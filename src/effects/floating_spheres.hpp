#pragma once

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the field problem (Laplace's equation) of a scene's spheres at their current positions in three dimensions.
/// Spheres: the conductors in order, then the electrodes. Groups: the equipotential groups in ascending order of id,
/// then one for each further potential of electrodes without a series resistor, then one for each potential source at a
/// resistor.
///
/// A sphere at an electrode side of its potential is moved to a gap of at least 0.1 % of its radius, because a sphere
/// cannot touch its image. The field between surfaces of equal potential is negligible. Two spheres joined by a
/// resistive contact shrink so that they have a gap.
laplace::SphereProblem make_sphere_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                           const NodeCharges& charges);

/// Converts the solution of a field problem of make_sphere_problem() to quantities of conductors and terminals.
/// Electrostatics::carried is left empty.
Electrostatics electrostatics_of(const Scene& scene, const laplace::SphereProblem& problem,
                                 const laplace::SphereSolution& solution);

/// Throws InputError for scene-file keys that the field of spheres does not support: keys of plane methods, tolerances
/// together with an accuracy, and devices other than the CPU.
void check_spheres(const Draft& draft);

/// Makes a field solver for spheres with FieldOptions::tolerance. `spheres`: number of conductors. Results are bitwise
/// identical for any number of threads. Throws InputError for a device other than the CPU.
laplace::SphereSolver make_sphere_solver(const FieldOptions& options, std::size_t spheres);

}  // namespace lichtenberg::effects
