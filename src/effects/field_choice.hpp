#pragma once

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "src/effects/groups.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// The electrical groups of the first instant: contacts that exist are made.
ElectricalGroups groups_at_start(const Scene& scene, const Bodies& bodies);

/// Relative tolerance in the energy norm of the cut-cell solves of a moving scene that gives none: a tenth of
/// mechanics.position_tolerance over the smallest radius, from 1e-5, which is what the links are wrong by, to 1e-3.
/// A field wrong by that share pulls a body wrong by twice that share of what its field can do at most, and while one
/// solve's error lasts no body goes farther than a contact away, a radius or so: two tenths of the position tolerance.
/// 1e-5 where charges follow potentials (a circuit), where CVODE estimates its errors by differences of such solves,
/// and by Euler's method, whose positions have no tolerance.
double usual_moving_tolerance(const Scene& scene);

/// The request of a scene that has one, as the solvers take it. For a run it is to hold for gaps down to
/// contact_discharge's, and the method must be one that can follow. Throws InputError for a device that the method
/// cannot use.
laplace::AccuracyRequest accuracy_request(const Scene& scene, bool for_a_run);

/// What is asked for, with what was chosen for it.
FieldOptions field_chosen(const FieldRequest& asked, const laplace::Choice& choice);

/// The scene with its field chosen for a run, if it asks for an accuracy. Estimates are made where the conductors are
/// at the start, with the charge that they have after the first output.every. Throws InputError if the accuracy cannot
/// be met.
Scene with_field_chosen(Scene scene);

/// Estimate of the error that the scene's choice leaves in a problem of the run.
double estimated_error(const FieldOptions& field, const laplace::LaplaceProblem& problem);

}  // namespace lichtenberg::effects
