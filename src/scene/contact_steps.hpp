#pragma once

#include <algorithm>
#include <cmath>

namespace lichtenberg {

/// Default relative energy error of contacts of grains. It equals the force error that the shipped scenes of charged
/// gases allow, so that a gas without charges resolves contacts equally well.
constexpr double usual_contact_accuracy = 1e-3;

/// Estimates the relative energy error of a contact of grains from the time step: 1 / (4 n^2), where n (`steps`) is the
/// number of contact substeps in the shortest possible contact. The scheme is of second order where several grains are
/// in contact. An isolated elastic contact has a smaller error, about n^-2.5. Measurements:
/// docs/measurements/granular.json.
inline double contact_error(int steps) { return 0.25 / (static_cast<double>(steps) * steps); }

/// Smallest number of contact substeps: with fewer, the error of a contact does not follow contact_error().
constexpr int fewest_contact_steps = 16;

/// Returns the smallest number of contact substeps with an error of at most `accuracy` (> 0) by contact_error(). The
/// result is at least 16 and at most 500, which is the value for 1e-6.
inline int contact_steps_for(double accuracy) {
  constexpr double most = 500;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(0.25 / accuracy)), double{fewest_contact_steps}, most));
}

}  // namespace lichtenberg
