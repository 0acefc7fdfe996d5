#pragma once

#include <optional>

namespace lichtenberg::network {

/// Parameters of the resistor models; each model needs some of them.
struct Parameters {
  std::optional<double> resistance;             ///< Ohm
  std::optional<double> resistance_per_length;  ///< Ohm/m: resistivity over a cross-section
  std::optional<double> sheet_resistance;       ///< Ohm (per square): resistivity over the depth
  std::optional<double> resistivity;            ///< Ohm m
  std::optional<double> contact_radius;         ///< Contact radius (m): half of a contact's width, its radius between
                                                ///< spheres
};

}  // namespace lichtenberg::network
