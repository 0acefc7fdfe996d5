#pragma once

#include <string>

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "src/effects/groups.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the equipotential groups of the conductors at the start, with the contacts of effects.contact_discharge
/// closed for the initial positions.
ElectricalGroups groups_at_start(const Scene& scene, const Bodies& bodies);

/// Returns the default relative tolerance (energy norm) of the linear solver for the cut-cell fields of moving
/// conductors. It is 1e-4 for a mechanics.position_tolerance of at least 1e-3 of the smallest radius. Below, it
/// decreases with the square of the position tolerance to 1e-5, the error of the stencil. The relation is empirical
/// (docs/measurements/benchmarks-field.json) and not a bound, because one body may have more of the error than another.
///
/// The tolerance is 1e-5 in a scene with a circuit, where charges follow potentials. It is 1e-5 for integrators without
/// position_tolerance: CVODE, which estimates its errors by differences of such solves, and Euler's method.
double usual_moving_tolerance(const Scene& scene);

/// Converts the field accuracy that a scene requests (field.accuracy) to a request of the field solvers. For a run the
/// accuracy is divided by 3, since errors vary while bodies move. It must then hold for gaps down to the contact
/// distance, and the method must be able to follow moving bodies. Throws InputError for a device that the method does
/// not support.
laplace::AccuracyRequest accuracy_request(const Scene& scene, bool for_a_run);

/// Converts the method, grid and tolerance that the field solvers chose for an accuracy to field options of a scene.
FieldOptions field_chosen(const FieldRequest& field_request, const laplace::Choice& choice);

/// Solves the field of spheres to the accuracy that the scene requests. Stores the tolerance with which it was reached,
/// and the error estimate, in the scene. Throws the exceptions of the solver.
laplace::AccurateSpheres solve_to_accuracy(Scene& scene, const laplace::SphereProblem& problem);

/// Returns a copy of the scene in which field options for a run replace a requested accuracy. It is unchanged without
/// such a request, or if a field of spheres is not valid at the start. Errors are estimated for the initial positions,
/// with the charges after the first output interval. Throws InputError if the accuracy cannot be reached, and the
/// exceptions of the solver.
Scene with_field_chosen(Scene scene);

/// Returns a warning if the grid of a plane field does not resolve a conductor or disk electrode (radius below a cell);
/// otherwise empty. It is empty if the scene requests an accuracy, whose error estimate covers this case.
std::string unresolved_bodies(const Scene& scene);

/// Returns an estimate of the relative error of field results for the field options of a scene and a field problem of
/// its run.
double estimated_error(const FieldOptions& field, const laplace::LaplaceProblem& problem);

}  // namespace lichtenberg::effects
