#pragma once

// Device form of an effect that is a pair force law (src/model/pair_law.hpp).

#include <algorithm>

#include "solvers/error.hpp"
#include "src/effects/device_forces.hpp"
#include "src/model/pair_part.hpp"

namespace lichtenberg::effects {

/// Returns a pair with about the largest pair force in the scene, which determines the quanta of fixed-point sums. Its
/// grains have the smallest radius and touch. Their charge is the largest of the scene, but at least 1 (q0).
/// `reach_of_smallest`: cutoff of the law for this pair (d0).
PairGeometry strongest_pair(const Scene& scene, double reach_of_smallest);

/// Returns strongest_pair() for a pair force law, with the cutoff of the law.
template <PairLaw Law>
PairGeometry strongest_pair_of(const Scene& scene, const Law& law) {
  const double radius = std::ranges::min(scene.conductors, {}, &Conductor::radius).radius;
  return strongest_pair(scene, law.reach(radius, radius));
}

/// Adds the memory of neighbour lists up to the cutoff `reach` (d0) to forces.bytes. Throws InputError for a cutoff
/// beyond half of the shortest side.
void add_pair_lists(const Scene& scene, double reach, DeviceForces& forces);

/// Adds the pair forces of a law on grains to those of a device, for the CPU executor only. The law is in reduced
/// units. Returns the added factory. Throws InputError for a cutoff beyond half of the shortest side.
template <PairLaw Law>
DevicePartForm& add_pair_law(const Scene& scene, const Law& law, DeviceForces& forces) {
  const auto [smallest, largest] = std::ranges::minmax(scene.conductors, {}, &Conductor::radius);
  const double reach =
      std::max({law.reach(smallest.radius, smallest.radius), law.reach(smallest.radius, largest.radius),
                law.reach(largest.radius, largest.radius)});
  add_pair_lists(scene, reach, forces);
  if (Law::charged) forces.charged = true;
  const PairGeometry strongest = strongest_pair_of(scene, law);
  DevicePartForm& form = forces.parts.emplace_back();
  form.reach = reach;
  form.make_on_host = [=](const parallel::HostExecutor& run) {
    return std::make_unique<PairPart<Law, parallel::HostExecutor>>(run, law, strongest);
  };
  return form;
}

/// Adds the pair forces of a law on grains to those of a device, for the CPU executor and for CUDA devices. CMake's
/// add_law_kernels must add the kernels to the target; otherwise the target does not link, even in builds without CUDA.
template <PairLaw Law>
DevicePartForm& add_pair_law_with_kernels(const Scene& scene, const Law& law, DeviceForces& forces) {
  DevicePartForm& form = add_pair_law(scene, law, forces);
  const PairGeometry strongest = strongest_pair_of(scene, law);
  form.make_on_cuda = [=](const parallel::CudaExecutor& run) { return make_cuda_part<Law>(run, law, strongest); };
  return form;
}

}  // namespace lichtenberg::effects
