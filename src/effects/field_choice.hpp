#pragma once

#include <string>

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "src/effects/groups.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the electrical groups of the first instant, with existing contacts closed.
ElectricalGroups groups_at_start(const Scene& scene, const Bodies& bodies);

/// Returns the default relative tolerance, in the energy norm, of the cut-cell solves of a moving scene. It is 1e-4 for
/// a mechanics.position_tolerance of at least 1e-3 of the smallest radius. Below, it decreases with the square of the
/// position tolerance to 1e-5, the error of the stencil. The relation is empirical, not a bound, because the norm is
/// global and one body may have more of the error than another. At 1e-3 of a radius, 1e-4 gives the same errors as
/// 1e-5. At 2.5e-4 of a radius, 2.5e-5 gives 10 % more error (docs/measurements/benchmarks-field.json).
///
/// The tolerance is 1e-5 where charges follow potentials (a circuit) and for CVODE, which estimates its errors by
/// differences of such solves. It is also 1e-5 for Euler's method, whose positions have no tolerance.
double usual_moving_tolerance(const Scene& scene);

/// Returns the solvers' form of the scene's accuracy request. For a run the accuracy applies to gaps down to
/// contact_discharge's, and the method must be able to follow moving bodies. Throws InputError for a device that the
/// method does not support.
laplace::AccuracyRequest accuracy_request(const Scene& scene, bool for_a_run);

/// Returns the field options that were chosen for a request.
FieldOptions field_chosen(const FieldRequest& field_request, const laplace::Choice& choice);

/// Solves the field of the scene's spheres to the requested accuracy, and stores the required tolerance in the scene.
/// Throws the exceptions of the solver.
laplace::AccurateSpheres solve_to_accuracy(Scene& scene, const laplace::SphereProblem& problem);

/// Returns the scene with field options chosen for a run, if it requests an accuracy. Errors are estimated at the
/// conductors' initial positions, with their charges after the first output.every. Throws InputError if the accuracy
/// cannot be reached, and the exceptions of the solver.
Scene with_field_chosen(Scene scene);

/// Returns a warning if a conductor or a disk electrode has a radius below a cell of the scene's grid, which then
/// barely resolves it; otherwise empty. For a requested accuracy, the error estimate includes this.
std::string unresolved_bodies(const Scene& scene);

/// Returns an estimate of the error of the scene's field options in a problem of the run.
double estimated_error(const FieldOptions& field, const laplace::LaplaceProblem& problem);

}  // namespace lichtenberg::effects
