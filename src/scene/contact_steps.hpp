#pragma once

#include <algorithm>
#include <cmath>

namespace lichtenberg {

/// What steps of contacts may leave where no effect has an accuracy: as much as shipped gases ask of their charges, so
/// that a gas without has the same contacts.
constexpr double usual_contact_accuracy = 1e-3;

/// About what is wrong of a contact's energy, over it, if the shortest that there could be has so many steps: 1 / (4
/// n^2). An elastic contact alone is wrong by up to .7 n^-2.5, since the end of its force, which is not smooth in
/// sqrt(t), falls anywhere within a step; where several meet, what others do is held linear in time over a step, of
/// second order. Energy books of gases have .04 to .17 n^-2, and up to .44 where a dense one was elastic for long
/// (src/granular/README.md, how many steps a contact has).
inline double contact_error(int steps) { return 0.25 / (static_cast<double>(steps) * steps); }

constexpr int fewest_contact_steps = 16;  ///< of 1e-3: with fewer the error of a contact does not fall as it should

/// The fewest steps that leave that accuracy, greater than 0, by the formula above; as many as 1e-6 asks for at most: a
/// solution to which others are compared says its own.
inline int contact_steps_for(double accuracy) {
  constexpr double most = 500;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(0.25 / accuracy)), double{fewest_contact_steps}, most));
}

}  // namespace lichtenberg
