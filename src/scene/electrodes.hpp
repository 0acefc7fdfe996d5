#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// The electrodes of a scene. Throws InputError for one that has no extent or lies outside the domain, for two of the
/// same name, and for a short circuit: electrodes that touch each other, or an electrode side of the domain, at another
/// potential.
std::vector<Electrode> build_electrodes(const Draft& draft);

/// From a disk or, in three dimensions, a sphere to an electrode, surface to surface (m), through periodic sides too;
/// negative if they overlap.
double gap(const Conductor& conductor, const Electrode& electrode, const Domain& domain);

/// Refuses electrodes that the multipole method cannot have: it solves disks, whole ones or centred on a side.
void check_disks_only(const Draft& draft, const std::vector<Electrode>& electrodes);

}  // namespace lichtenberg
