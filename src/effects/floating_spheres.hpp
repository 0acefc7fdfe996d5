#pragma once

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the field problem of a scene's spheres at their current positions (D 5.2, 5.3, in three dimensions): the
/// conductors in order, then the electrodes. Groups: the electrical groups in ascending order of id. Then one for each
/// electrode potential without a resistor that no group has, and one for each potential source at the end of a
/// resistor. A sphere that touches an electrode side and has its potential is moved to a gap of 0.1 % of its radius.
/// Between surfaces of equal potential the field is negligible, and images of equal sign cannot touch.
laplace::SphereProblem make_sphere_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                           const NodeCharges& charges);

/// Converts the solution of a problem of make_sphere_problem to the scene's quantities.
Electrostatics electrostatics_of(const Scene& scene, const laplace::SphereProblem& problem,
                                 const laplace::SphereSolution& solution);

/// Throws InputError for keys that the field of spheres does not support: keys of planar methods, tolerances together
/// with an accuracy, and devices other than the CPU.
void check_spheres(const Draft& draft);

/// Makes a solver at the tolerance of a single solve, for a scene of `spheres` conductors. Results are bitwise
/// identical for any number of threads.
laplace::SphereSolver make_sphere_solver(const FieldOptions& options, std::size_t spheres);

}  // namespace lichtenberg::effects
