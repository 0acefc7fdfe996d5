#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "src/analysis/network.hpp"
#include "src/analysis/packing.hpp"
#include "src/model/frame.hpp"
#include "src/record/recorder.hpp"

namespace lichtenberg {

/// A frame as the recorder takes it; a scene without electrical contacts has no network.
FrameColumns columns_of(const Frame& frame, const std::optional<analysis::Network>& network);

/// A relaxation to rest after some iterations.
struct RelaxationState {
  std::int64_t iteration = 0;
  double energy = 0;         ///< J
  double largest_force = 0;  ///< N
};

/// /relaxation: iterations ever farther apart.
ColumnGroup columns_of(std::span<const RelaxationState> states);

/// /packing: what holds the particles of the last frame.
ColumnGroup columns_of(const analysis::Packing& packing);

}  // namespace lichtenberg
