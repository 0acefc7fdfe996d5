#pragma once

#include <optional>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Estimated cost of a field solve on one core or on the selected device, from measured figures per unknown
/// (docs/measurements/explain.json). Machines differ by factors of two and more.
struct FieldCost {
  double bytes = 0;           ///< memory on the host or device, including libraries at program start
  double single_seconds = 0;  ///< a single solve, at field.tolerance
  double moving_seconds = 0;  ///< a solve in a moving scene, at field.moving_tolerance
};

/// Estimates the memory and time of a field solve. `size`: number of cells of the whole grid, including cells inside
/// conductors; without a grid, the number of unknowns.
FieldCost estimate_field_cost(const FieldOptions& options, double size);
/// Estimates the memory and time of a field solve for spheres in three dimensions. The arguments are the numbers of
/// unknowns at the tolerance of a single solve and of a solve in a moving scene.
FieldCost estimate_sphere_cost(const FieldOptions& options, double single_unknowns, double moving_unknowns);

/// Estimated number of field solves of a run.
struct FieldSolves {
  double whole = 0;        ///< on the full grid
  double predictions = 0;  ///< on the coarser grid of the predictor
};

/// Estimates the number of field solves of a run. For Euler's method it is the number of steps until stop.time. For
/// CVODE it is accurate to about a factor of two (docs/measurements/explain.json), for conductors with current
/// injection, linear drag and electrical contacts. They must be in the plane or lie in a dish (fix_z). Empty for other
/// scenes. Throws InputError if contacts at the start form a short circuit.
std::optional<FieldSolves> estimate_field_solves(const Scene& scene);

/// Estimated work until a packing is at rest, with the method of its [minimize].
struct PackingCost {
  double filling = 0;  ///< fraction of the domain; overlaps count twice
  double iterations = 0;
  double seconds = 0;  ///< on one core
};

/// Estimates the work until a packing is at rest, to about a factor of three. Empty for gradient descent, which is
/// impractically slow.
std::optional<PackingCost> estimate_packing_cost(const Scene& scene);

/// Result of a trial run without output over about two seconds of processor time, or until the run's end.
struct TrialRun {
  double reached = 0;  ///< simulated time, s
  bool over = false;   ///< the run ended within the trial
  double seconds = 0;  ///< processor time extrapolated to the whole run
};

/// Runs the scene for a short time to estimate the time of the whole run. Empty if the trial covers less than 0.5 % of
/// the run, or fails, because no extrapolation is possible then.
std::optional<TrialRun> run_trial(const Scene& scene);

}  // namespace lichtenberg
