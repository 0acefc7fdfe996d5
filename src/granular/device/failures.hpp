#pragma once

// Error messages of outer steps on a device.

#include <string>

#include "solvers/error.hpp"
#include "src/granular/device/contact_data.hpp"

namespace lichtenberg::granular::device {

/// Throws Failure if a step failed: grains fly through each other or through walls, or leave the domain; contacts are
/// too many for their list; positions are not finite. `path`: of the scene; `time`: t0.
inline void require_success(const StepResults& results, const std::string& path, double time) {
  const auto fail = [&](const std::string& since, const std::string& what) {
    throw Failure(path + ": " + since + " t = " + std::to_string(time) + " t0 " + what);
  };
  if (results.passed)
    throw Failure("grain " + std::to_string(results.passed - 1) +
                  " and another fly through each other: the contact is too soft for their impact; a larger "
                  "stiffness, of a stage its equilibration.stiffness, or a lower temperature is needed");
  if (results.escaped)
    throw Failure("grain " + std::to_string(results.escaped - 1) +
                  " flies through a wall: the contact is too soft for its speed and for the forces on it; a larger "
                  "stiffness of the walls (effects.flat_walls.stiffness, or young) is needed");
  if (results.crossed)
    fail("at", "a charge has left the domain through the " + std::string(side_names[results.crossed - 1]) +
                   " side: contacts with the sides must be stiffer, or steps shorter");
  if (results.overfull)
    fail("at", "more contacts begin in a step than there are near pairs: a shorter mechanics.step is needed");
  if (results.lost) fail("from", "on the grains' positions are not finite");
}

}  // namespace lichtenberg::granular::device
