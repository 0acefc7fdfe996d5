#pragma once

#include <optional>

namespace lichtenberg::network {

/// Parameters of the resistor models (resistor.hpp). Each model needs some of them; the others must be absent.
struct Parameters {
  std::optional<double> resistance;             ///< Resistance of every resistor (Ohm)
  std::optional<double> resistance_per_length;  ///< Resistance per length (Ohm/m): resistivity over the cross-section
  std::optional<double> sheet_resistance;       ///< Sheet resistance (Ohm per square): resistivity over the thickness
  std::optional<double> resistivity;            ///< Resistivity (Ohm m)
  std::optional<double> contact_radius;  ///< Radius of the contact spot of spheres, half width of that of disks (m)
};

}  // namespace lichtenberg::network
