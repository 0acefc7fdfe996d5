#pragma once

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Makes the electrodes of a scene from the file's [[electrode]]s. Throws InputError for a shape of another dimension
/// than the domain, and for two electrodes of the same name. Throws InputError for an electrode without extent, outside
/// the domain or too thin for the grid of the field. Throws InputError for a short circuit: an electrode that touches
/// another electrode or an electrode side at another potential, or two such sides that meet. Throws InputError for an
/// electrode behind a resistor that touches another electrode. In three dimensions it throws InputError for a sphere on
/// a side or in contact with another electrode.
std::vector<Electrode> build_electrodes(const Draft& draft);

/// Returns the surface-to-surface distance (m) of a disk, or of a sphere in three dimensions, from an electrode;
/// negative if they overlap. In three dimensions the nearest periodic image counts.
double gap(const Conductor& conductor, const Electrode& electrode, const Domain& domain);

/// Throws InputError for electrodes that the multipole method cannot solve. The method allows whole disks and disks
/// centred on a side.
void check_disks_only(const Draft& draft, const std::vector<Electrode>& electrodes);

}  // namespace lichtenberg
