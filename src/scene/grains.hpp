#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Throws InputError for keys, effects and sides of the domain that a scene of grains (with [units]) does not allow. In
/// other scenes it throws InputError for those that require [units], and for keys of [mechanics] that the integrator
/// does not read.
void check_grains(const Draft& draft);

/// Fills in the defaults of a scene of grains that differ from those of conductors, in reduced units. Called before
/// populations are drawn.
void fill_in_grains(Draft& draft);

/// Returns the relative energy error of a contact over contact_error(): 4 with surface forces (surface_key()), 1
/// without. Dashpots of rough grains act with predicted velocities. In a contact of frequency w with substeps h these
/// are too large by (w h)^2 / 2 = pi^2 / (2 n^2). The dissipation is the part 1 - e^2 of the energy, and the error is
/// thus 5 (1 - e^2) / n^2 at weak damping: 1 / n^2 at e = 0.9.
double contact_error_factor(const Scene& scene);

/// Fills in the default time step (t0) and number of contact substeps of a scene of grains, which depend on its
/// effects.
void fill_in_steps(const Draft& draft, Scene& scene);

/// Sets the charges of populations of grains, and Gaussian velocities of those with a temperature. Throws InputError
/// for keys of charges that contradict each other, and for too many grains for the integrator. Throws InputError for a
/// domain shorter than two diameters of its largest grain, and for an equilibration stage too short for the rounding of
/// time.
void complete_grains(const Draft& draft, Scene& scene);

}  // namespace lichtenberg
