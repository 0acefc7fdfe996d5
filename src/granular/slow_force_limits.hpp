#pragma once

#include "src/model/grain_contact_law.hpp"
#include "src/scene/contact_attraction.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

// Limits of steps with slow forces, by the strictest effect of a scene. Reduced units.

/// Returns the largest path (d0) of the fastest grain in a step: a part of the shortest length over which forces
/// change.
double path_by_length(const Scene& scene);
/// Returns the path (d0) at which holding forces is as wrong as the most accurate forces are (path_for_accuracy).
/// Throws Failure if no effect has a StepLimits::force_accuracy.
double path_by_accuracy(const Scene& scene);
/// Returns the sum of the attractions of all effects.
ContactAttraction contact_attraction(const Scene& scene);
/// Returns the longest time (t0) of slow forces between grains of at most this charge (q0) and at least this mass (m0).
double max_outer_step(const ContactAttraction& attraction, const GrainContactLaw& law, double charge, double lightest);

}  // namespace lichtenberg::granular
