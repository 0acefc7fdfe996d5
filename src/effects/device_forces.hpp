#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solvers/periodic/accuracy.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/model/device_part.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Forces and charge exchanges that the steps of a gas on a device compute, in reduced units. Each effect of the scene
/// adds its part (EffectKind::device).
struct DeviceForces {
  std::optional<periodic::MeshChoice> mesh;         ///< mesh of the sum over charges; empty: no Coulomb forces
  double strength = 0;                              ///< K, prefactor of that sum
  double polarizability = 0, dipole_tolerance = 0;  ///< 0: no dipoles
  bool charged = false, exchanges = false;
  ImpactExchange exchange{};
  std::vector<DeviceForm<DeviceDrive>> drives{};  ///< external drives of grains (src/model/drive_part.hpp)
  std::vector<DevicePartForm> parts{};            ///< pair forces (device_pair.hpp)
  double bytes = 0;                               ///< estimated device memory
};

/// Throws InputError with the message that device = "cuda" does not support `what`.
[[noreturn]] void refuse_on_device(const Scene& scene, const std::string& what);

/// Largest skin (d0) of the device's lists in memory estimates; a gas of T = 10 has it.
constexpr double widest_skin = 2.4;
/// Returns the number of grains within `range` (d0) of a grain at uniform density.
double grains_within(const Scene& scene, double range);

}  // namespace lichtenberg::effects
