#pragma once

// Device form of an effect that is a pair force law (src/model/pair_law.hpp).

#include <algorithm>

#include "solvers/error.hpp"
#include "src/effects/device_forces.hpp"
#include "src/model/pair_part.hpp"

namespace lichtenberg::effects {

/// Returns the pair with about the largest force of the scene's grains. Its grains have the smallest radius and are in
/// contact. Their charge is the largest of the scene, but at least 1 (q0).
PairGeometry strongest_pair(const Scene& scene, double reach_of_smallest);
/// Adds the memory of the lists, and throws InputError for a cutoff (d0) beyond half of the box.
void add_pair_lists(const Scene& scene, double reach, DeviceForces& forces);

/// Adds the forces of `law` on grains, for the host executor, in reduced units.
template <class Law>
DevicePartForm& add_pair_law(const Scene& scene, const Law& law, DeviceForces& forces) {
  const auto [smallest, largest] = std::ranges::minmax(scene.conductors, {}, &Conductor::radius);
  const double reach =
      std::max({law.reach(smallest.radius, smallest.radius), law.reach(smallest.radius, largest.radius),
                law.reach(largest.radius, largest.radius)});
  add_pair_lists(scene, reach, forces);
  if (NeedsCharges<Law>) forces.charged = true;
  const PairGeometry strongest = strongest_pair(scene, law.reach(smallest.radius, smallest.radius));
  DevicePartForm& form = forces.parts.emplace_back();
  form.reach = reach;
  form.make_on_host = [=](const parallel::HostExecutor& run) {
    return std::make_unique<PairPart<Law, parallel::HostExecutor>>(run, law, strongest);
  };
  return form;
}

/// Adds the forces of `law` with CUDA kernels, which CMake's add_law_kernels adds to a target. A target without them
/// does not link, in builds without CUDA either.
template <class Law>
DevicePartForm& add_pair_law_with_kernels(const Scene& scene, const Law& law, DeviceForces& forces) {
  DevicePartForm& form = add_pair_law(scene, law, forces);
  const PairGeometry strongest = strongest_pair(scene, 0);
  form.make_on_cuda = [=](const parallel::CudaExecutor& run) { return make_cuda_part<Law>(run, law, strongest); };
  return form;
}

}  // namespace lichtenberg::effects
