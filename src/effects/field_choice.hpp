#pragma once

#include <string>

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "src/effects/groups.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// The electrical groups of the first instant: contacts that exist are made.
ElectricalGroups groups_at_start(const Scene& scene, const Bodies& bodies);

/// Relative tolerance in the energy norm of the cut-cell solves of a moving scene that gives none: 1e-4 from a
/// mechanics.position_tolerance of 1e-3 of the smallest radius on, with the square of that below, and at least 1e-5,
/// which is what the links are wrong by. Measured, not a bound, since the norm is that of the whole field and one body
/// may have more of the error than another: at 1e-3 of a radius runs with 1e-4 have the errors of runs with 1e-5, at
/// 2.5e-4 of one 2.5e-5 costs a tenth more error (validation/benchmarks/README.md).
/// 1e-5 where charges follow potentials (a circuit), where CVODE estimates its errors by differences of such solves,
/// and by Euler's method, whose positions have no tolerance.
double usual_moving_tolerance(const Scene& scene);

/// The request of a scene that has one, as the solvers take it. For a run it is to hold for gaps down to
/// contact_discharge's, and the method must be one that can follow. Throws InputError for a device that the method
/// cannot use.
laplace::AccuracyRequest accuracy_request(const Scene& scene, bool for_a_run);

/// What is asked for, with what was chosen for it.
FieldOptions field_chosen(const FieldRequest& asked, const laplace::Choice& choice);

/// Solves the field of the scene's spheres, which asks for an accuracy, and keeps the tolerance that this takes as the
/// scene's. Throws as the solver does.
laplace::AccurateSpheres solve_to_accuracy(Scene& scene, const laplace::SphereProblem& problem);

/// The scene with its field chosen for a run, if it asks for an accuracy. Estimates are made where the conductors are
/// at the start, with the charge that they have after the first output.every. Throws InputError if the accuracy cannot
/// be met.
Scene with_field_chosen(Scene scene);

/// A warning if a conductor or a disk electrode has a radius below a cell of the grid that the scene names, which then
/// hardly sees it; else nothing. Where an accuracy is asked for, the estimate of the error says so.
std::string unresolved_bodies(const Scene& scene);

/// Estimate of the error that the scene's choice leaves in a problem of the run.
double estimated_error(const FieldOptions& field, const laplace::LaplaceProblem& problem);

}  // namespace lichtenberg::effects
