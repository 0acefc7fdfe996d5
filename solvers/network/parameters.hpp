#pragma once

#include <optional>

namespace lichtenberg::network {

/// What the models are told. Each says which ones it needs.
struct Parameters {
  std::optional<double> resistance;             ///< Ohm
  std::optional<double> resistance_per_length;  ///< Ohm/m: resistivity over a cross-section
  std::optional<double> sheet_resistance;       ///< Ohm (a square): resistivity over the depth
  std::optional<double> resistivity;            ///< Ohm m
  std::optional<double> spot;                   ///< m, half of a contact's width; its radius between spheres
};

}  // namespace lichtenberg::network
