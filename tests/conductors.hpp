#pragma once

#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/scene/scene.hpp"
#include "tests/near.hpp"

// Common definitions of tests of the effects.

namespace lichtenberg::conductors {

inline constexpr double radius = 1e-3;

/// Scene of conductors of radius 1 mm in a box of 10 cm, with contacts at a gap of 1 mm.
inline Scene scene_of(std::vector<Vec2> positions) {
  Scene scene;
  scene.domain.size = {0.1, 0.1};
  scene.medium = {.permittivity = 4e-11, .viscosity = 0.7, .depth = 2 * radius};
  for (const Vec2 position : positions) scene.conductors.push_back({.position = in_space(position), .radius = radius});
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = radius, .hysteresis = 0.1});
  scene.mechanics.position_tolerance = 1e-6;
  return scene;
}

inline Electrode electrode_of(std::string name, Shape shape, double potential) {
  return {std::move(name), shape, potential};
}

}  // namespace lichtenberg::conductors
