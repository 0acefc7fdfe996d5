#pragma once

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the field problem (Laplace's equation) of a scene's spheres at their current positions in three dimensions.
/// Spheres: the conductors in order, then the electrodes. Groups: first the equipotential groups in ascending order of
/// id. Then follows one group for each further potential of electrodes without a series resistor, then one for each
/// potential source at a resistor.
///
/// Spheres that have the potential of an electrode side or a resistive contact to a side are moved away from it. Their
/// gap is then at least 0.1 % of their radius. A sphere cannot touch its image, and the field between surfaces of equal
/// potential is negligible. Two spheres joined by a resistive contact shrink if they would otherwise have no gap.
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
/// identical for any number of threads. Throws InputError for a device that the method does not support.
laplace::SphereSolver make_sphere_solver(const FieldOptions& options, std::size_t spheres);

}  // namespace lichtenberg::effects
