#pragma once

#include "src/model/grain_contact_law.hpp"
#include "src/scene/contact_attraction.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

// Limits of steps that hold forces, by the strictest effect of a scene. Reduced units.

/// The way (d0) that the fastest grain may fly in a step: a part of the shortest length over which forces change.
double way_by_length(const Scene& scene);
/// The way (d0) at which holding forces costs what the error of the most accurate forces does (way_for). Throws Failure
/// if no effect has a StepLimits::force_accuracy.
double way_by_accuracy(const Scene& scene);
/// The sum of the attractions of all effects.
ContactAttraction contact_attraction(const Scene& scene);
/// The time (t0) for which forces may be held between grains of at most this charge and at least this mass (m0).
double longest_hold(const ContactAttraction& attraction, const GrainContactLaw& law, double charge, double lightest);

}  // namespace lichtenberg::granular
