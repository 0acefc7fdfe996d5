#pragma once

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// The field problem of a scene's spheres where they are now (D 5.2, 5.3, in space): the conductors in order, then the
/// electrodes. Groups: the electrical groups in ascending order of id, then one for each potential of an electrode
/// without a resistor that no group has, then one for each supply at the end of a resistor. What touches an electrode
/// side, which has that side's potential, is put a thousandth of a radius off: between surfaces of one potential there
/// is no field to speak of, and images of one sign cannot touch.
laplace::SphereProblem make_sphere_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                           const NodeCharges& charges);

/// What its solution says of the scene.
Electrostatics electrostatics_of(const Scene& scene, const laplace::SphereProblem& problem,
                                 const laplace::SphereSolution& solution);

/// Throws InputError for what a scene has and the field of spheres has not: another device than the CPU, other
/// methods.
void check_spheres(const Draft& draft);

/// At the tolerance of a single solve, for a scene of so many conductors. Threads change no bit of its results.
laplace::SphereSolver make_sphere_solver(const FieldOptions& options, std::size_t spheres);

}  // namespace lichtenberg::effects
