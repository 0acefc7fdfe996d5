#pragma once

#include <optional>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Whether a device computes what costs something; else a core.
bool runs_on_device(const FieldOptions& options);

/// What a field solve will cost on one core or that device, from measured figures an unknown (README.md of this
/// folder). An estimate: machines differ by factors of two and more.
struct FieldCost {
  double bytes = 0;           ///< of memory, its own or the device's, the program's own start included
  double single_seconds = 0;  ///< a solve on its own, at field.tolerance
  double moving_seconds = 0;  ///< a solve in a moving scene, at field.moving_tolerance
};

/// `size`: cells of the whole grid, those under conductors included; without a grid, unknowns.
FieldCost estimate_field_cost(const FieldOptions& options, double size);
/// Of spheres in space, whose unknowns follow from the tolerance.
FieldCost estimate_sphere_cost(const FieldOptions& options, double single_unknowns, double moving_unknowns);

/// How often a run solves for a field.
struct FieldSolves {
  double whole = 0;        ///< of it all
  double predictions = 0;  ///< on a coarser grid between them
};

/// Euler's number is given by its steps to the end of the run; CVODE's is known to a factor of two or so (README.md of
/// this folder) for scenes whose conductors are fed, dragged and discharged until they rest, in the plane or lying in a
/// dish, and empty for others. Throws InputError if contacts at the start are a short circuit.
std::optional<FieldSolves> estimate_field_solves(const Scene& scene);

}  // namespace lichtenberg
