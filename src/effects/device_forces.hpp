#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solvers/periodic/accuracy.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/model/device_part.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Forces and exchanges that the steps of a gas on a device compute. Each effect of the scene adds its part
/// (EffectKind::device). Reduced units.
struct DeviceForces {
  std::optional<periodic::MeshChoice> mesh;         ///< of the sum over charges; empty: charges do not act
  double strength = 0;                              ///< K of that sum
  double polarizability = 0, dipole_tolerance = 0;  ///< 0: no dipoles
  bool charged = false, exchanges = false;
  ImpactExchange exchange{};
  std::vector<DeviceForm<DeviceDrive>> drives{};  ///< what surrounds grains (src/model/drive_part.hpp)
  std::vector<DevicePartForm> parts{};            ///< forces of pairs (device_pair.hpp)
  double bytes = 0;                               ///< of the device's memory, an estimate
};

/// Throws InputError: device = "cuda" has no `what`.
[[noreturn]] void refuse_on_device(const Scene& scene, const std::string& what);

/// The widest skin (d0) of the device's lists for which memory is estimated; a gas of T = 10 has it.
constexpr double widest_skin = 2.4;
/// The number of grains within `range` (d0) of one, if grains are evenly spread.
double grains_within(const Scene& scene, double range);

}  // namespace lichtenberg::effects
