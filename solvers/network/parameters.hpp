#pragma once

#include <optional>

namespace lichtenberg::network {

/// Parameters of the resistor models (resistor.hpp). Each model needs some of them; the others must be absent.
struct Parameters {
  std::optional<double> resistance;             ///< Resistance of every resistor (Ohm)
  std::optional<double> resistance_per_length;  ///< Resistance per length (Ohm/m): resistivity over the cross-section
  std::optional<double> sheet_resistance;       ///< Sheet resistance (Ohm per square): resistivity over the thickness
  std::optional<double> resistivity;            ///< Resistivity (Ohm m)
  std::optional<double> contact_radius;   ///< Radius of the contact spot of spheres, half width of that of disks (m)
  std::optional<double> film_resistance;  ///< Resistance of a surface film times its area (Ohm m^2)
  /// Elastic modulus E* of a contact (Pa): 1/E* is the sum of (1 - nu^2)/E over both bodies
  std::optional<double> elastic_modulus;
  std::optional<double> hardness;     ///< Hardness (Pa): load over the area that truly touches
  std::optional<double> spot_radius;  ///< Radius of a microscopic spot that truly touches (m)
};

}  // namespace lichtenberg::network
