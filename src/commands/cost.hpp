#pragma once

#include <optional>

#include "src/scene/scene.hpp"

namespace lichtenberg {

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

/// Estimates the work until a packing is at rest, by the method of its [minimize].
struct PackingCost {
  double filling = 0;  ///< of the domain, overlaps counted twice
  double iterations = 0;
  double seconds = 0;  ///< on one core
};

/// Known to a factor of three (README.md of this folder). Empty for gradient descent, which nobody waits for.
std::optional<PackingCost> estimate_packing_cost(const Scene& scene);

/// A run that was carried on in memory for two seconds of processor time, or to its end.
struct TriedRun {
  double reached = 0;  ///< s of the run
  bool over = false;   ///< it came to its end
  double seconds = 0;  ///< of processor time for the whole run, at the pace of what was tried
};

/// Empty where less than a two-hundredth of the run was reached, or the run failed: then no pace holds.
std::optional<TriedRun> try_run(const Scene& scene);

}  // namespace lichtenberg
