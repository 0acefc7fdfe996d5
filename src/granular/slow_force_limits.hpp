#pragma once

#include "src/model/grain_contact_law.hpp"
#include "src/scene/contact_attraction.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular {

// Limits of steps with slow forces, by the strictest effect of a scene. Reduced units.

/// Returns the largest path (d0) of the fastest grain in a step of constant slow forces (all forces except contacts).
/// It is max_relative_path times the shortest length over which forces of an effect change (StepLimits::force_length),
/// or times 1 d0 if that is less.
double path_by_length(const Scene& scene);
/// Returns the path (d0) of the fastest grain in a step of constant slow forces. The error of this step is about that
/// of the most accurate forces (StepLimits::force_accuracy, path_for_accuracy()). Throws Failure if no effect of the
/// scene states the accuracy of its forces.
double path_by_accuracy(const Scene& scene);
/// Returns the largest path (d0) of the fastest grain in a step: path_by_length() with mechanics.step; otherwise
/// path_by_accuracy(), or path_per_search if only contacts act. A step then lasts as long as a list of candidate pairs.
/// Throws the exceptions of path_by_accuracy().
double path_in_step(const Scene& scene);
/// Returns the sum of the attractions of two grains in contact by all effects of the scene.
ContactAttraction contact_attraction(const Scene& scene);
/// Returns a limit of the outer step (t0), over which slow forces (all except contacts) are constant, that keeps the
/// oscillation of bound pairs stable: a quarter of its period. `charge`: largest charge (q0); `lightest`: smallest mass
/// (m0); infinite without an attraction.
double max_outer_step(const ContactAttraction& attraction, const GrainContactLaw& law, double charge, double lightest);

}  // namespace lichtenberg::granular
