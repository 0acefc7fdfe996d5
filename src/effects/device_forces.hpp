#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solvers/periodic/bounded.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/model/device_part.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Forces, drives and charge exchange of grains that are computed on a device, in reduced units. Each effect of the
/// scene adds its contribution (EffectKind::device).
struct DeviceForces {
  std::optional<periodic::MeshChoice> mesh;         ///< particle mesh of the Coulomb sum; empty: no Coulomb forces
  periodic::MeshRequest request{};                  ///< requirements on this mesh, without image charges
  periodic::Enclosure enclosure{};                  ///< conditions for the field at the sides
  double strength = 0;                              ///< K, coupling constant of the Coulomb sum
  double polarizability = 0, dipole_tolerance = 0;  ///< of induced dipoles; 0: no dipoles
  bool charged = false, exchanges = false;          ///< true if grains have charges, and if they exchange charge
  CollisionExchange exchange{};
  std::vector<double> affinity{};                 ///< of each grain, for the exchange by material
  std::vector<DeviceForm<DeviceDrive>> drives{};  ///< external drives of grains (src/model/drive_part.hpp)
  std::vector<DevicePartForm> parts{};            ///< pair forces (device_pair.hpp)
  double bytes = 0;                               ///< estimated device memory for these computations
};

/// Throws InputError with a message that device = "cuda" does not support `what`, a feature of the scene.
[[noreturn]] void refuse_on_device(const Scene& scene, const std::string& what);

/// Largest skin (d0) of neighbour lists on a device that estimates of memory assume.
constexpr double widest_skin = 2.4;
/// Returns the expected number of grains within a distance `range` (d0) of a grain at uniform density.
double grains_within(const Scene& scene, double range);

}  // namespace lichtenberg::effects
