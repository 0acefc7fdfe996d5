#pragma once

#include <algorithm>
#include <cmath>

namespace lichtenberg {

/// What steps of contacts may leave where no effect has an accuracy: as much as shipped gases ask of their charges, so
/// that a gas without has the same contacts.
constexpr double usual_contact_accuracy = 1e-3;

/// What is wrong of a contact's energy, over it, at most, if the shortest that there could be has so many steps: 1 / (4
/// n^2). An elastic contact alone is wrong by up to .7 n^-2.5, since the end of its force, which is not smooth in
/// sqrt(t), falls anywhere within a step; where several meet, what others do is held linear in time over a step, of
/// second order. Energy books of gases have .04 to .17 n^-2 (src/granular/README.md, how many steps a contact has).
inline double contact_error(int steps) { return 0.25 / (static_cast<double>(steps) * steps); }

/// The fewest steps that leave no more than that accuracy, greater than 0; at least 16, those of 1e-3, since with
/// fewer the error of a contact alone does not fall as it should, and at most those that a scene may ask for.
inline int contact_steps_for(double accuracy) {
  constexpr double fewest = 16, most = 1e4;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(0.25 / accuracy)), fewest, most));
}

}  // namespace lichtenberg
