#pragma once

#include <algorithm>
#include <cmath>

namespace lichtenberg {

/// Default error of contact steps. Shipped gases allow the same error for the forces of their charges, so a gas without
/// charges resolves contacts equally well.
constexpr double usual_contact_accuracy = 1e-3;

/// Estimates the relative energy error of a contact if the shortest possible contact has `steps` steps: 1 / (4 n^2). An
/// isolated elastic contact has an error of up to .7 n^-2.5. Its force ends anywhere within a step and is not smooth in
/// sqrt(t). Where several grains are in contact, the forces of the others are linear in time over a step, which is of
/// second order. Energy budgets of gases show .04 to .17 n^-2, and up to .44 n^-2 for a dense gas that was elastic for
/// a long time (docs/measurements/granular.json).
inline double contact_error(int steps) { return 0.25 / (static_cast<double>(steps) * steps); }

constexpr int fewest_contact_steps = 16;  ///< error 1e-3: below 16 steps a contact's error does not follow the formula

/// Returns the smallest number of steps that gives this accuracy (> 0) by contact_error(). The result is at most 500,
/// which is the value for 1e-6. Reference solutions set their own number.
inline int contact_steps_for(double accuracy) {
  constexpr double most = 500;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(0.25 / accuracy)), double{fewest_contact_steps}, most));
}

}  // namespace lichtenberg
