#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Makes the electrodes of a scene from the file's [[electrode]]s. Throws InputError for a shape of another dimension
/// than the domain, and for two electrodes of the same name. Throws InputError for a bar without length and for an
/// electrode outside the domain. Throws InputError for a ring, or a disk centred outside, that extends into the domain
/// by less than half a cell diagonal of the field's grid. Throws InputError for a short circuit between electrodes or
/// electrode sides at different potentials that touch or meet. Throws InputError for an electrode behind a resistor
/// that touches another electrode or an electrode side. In three dimensions it throws InputError for a sphere that
/// touches another electrode or a side, or is centred beyond a periodic side.
std::vector<Electrode> build_electrodes(const Draft& draft);

/// Returns the surface-to-surface distance (m) of a disk, or of a sphere in three dimensions, from an electrode;
/// negative if they overlap. In three dimensions the nearest periodic image counts.
double gap(const Conductor& conductor, const Electrode& electrode, const Domain& domain);

/// Throws InputError for electrodes that the multipole method cannot solve. The method allows disks without overlap
/// that are whole or centred on a side, but not where two electrode sides meet.
void check_disks_only(const Draft& draft, const std::vector<Electrode>& electrodes);

}  // namespace lichtenberg
