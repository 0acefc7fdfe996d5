#pragma once

#include <optional>

#include "src/analysis/network.hpp"
#include "src/effects/conductor_frame.hpp"

namespace lichtenberg {

/// Recorded columns of a run of conductors at one instant.
inline Frame columns_of(const ConductorFrame& state, const std::optional<analysis::ContactNetwork>& network) {
  Frame frame = columns_of(state);
  if (network) analysis::add_columns(*network, frame);
  return frame;
}

}  // namespace lichtenberg
