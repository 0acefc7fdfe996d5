#pragma once

#include <algorithm>
#include <thread>

#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Returns the number of threads for the grains of a scene: mechanics.threads, or by default one for each core, but a
/// single thread for few grains.
inline int threads_for_grains(const Scene& scene) {
  if (scene.mechanics.threads > 0) return scene.mechanics.threads;
  constexpr std::size_t few = 4000;  // below this, threads cost more than they save
  return scene.conductors.size() < few ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

}  // namespace lichtenberg
