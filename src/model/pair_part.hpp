#pragma once

// Pair force law (pair_law.hpp) on a device.

#include <algorithm>
#include <memory>

#ifdef __CUDACC__
#include "solvers/parallel/cuda_executor.hpp"
#endif
#include "src/model/device_part.hpp"
#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// Calls use(PairForce, force over distance, separation) for each neighbour j of grain i within the cutoff of a pair
/// force law. The separation is the vector from grain j to grain i. Units are reduced.
template <PairLaw Law, class Use>
LICHTENBERG_HOST_DEVICE void for_each_partner(const Law& law, const DeviceGrains& grains,
                                              const NearestImage<3>& nearest, int i, const Use& use) {
  for (int e = grains.partners.begin(i); e < grains.partners.end(i); ++e) {
    const int j = grains.partners.partner[e];
    Vec3 separation = grains.position[i] - grains.position[j];
    for (int k = 0; k < 3; ++k) separation[k] = nearest(separation[k], k);
    const double distance = norm(separation), reach = law.reach(grains.radius[i], grains.radius[j]);
    if (!(distance < reach)) continue;
    PairGeometry geometry{distance, reach, grains.radius[i], grains.radius[j]};
    if constexpr (Law::charged) geometry.charge_i = grains.charge[i], geometry.charge_j = grains.charge[j];
    const PairForce of = law(geometry);
    use(of, over_distance<Law>(of, distance), separation);
  }
}

/// Pair forces of a law on grains on a device. One thread sums the forces on one grain over its neighbours. The law is
/// evaluated twice for each pair, which costs a device less than adding to two grains.
template <PairLaw Law, class Executor>
class PairPart final : public DevicePart {
 public:
  /// Makes the device implementation of a pair force law. `strongest`: a pair with about the largest force that is
  /// expected.
  PairPart(const Executor& run, const Law& law, const PairGeometry& strongest)
      : run_(&run), law_(law), strongest_(strongest) {}

  PairUnits size() const override {
    const PairForce most = law_(strongest_);
    return {over_distance<Law>(most, strongest_.distance) * strongest_.distance, law_.energy_unit() * most.energy};
  }

  void add_forces(const DeviceGrains& grains, const PairUnits& units, FixedPointVec* force,
                  std::int64_t* energy) const override {
    constexpr int a_part = 256;
    const Law law = law_;
    const NearestImage<3> nearest(grains.box);
    const int n = grains.count;
    const double per_force = 1 / units.force, per_energy = 0.5 * law.energy_unit() / units.energy;
    run_->sum_segments((n + a_part - 1) / a_part,
                       [=] LICHTENBERG_HOST_DEVICE(int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
                         const int i = p * a_part + t;
                         FixedPointVec sum = force[i];
                         std::int64_t half = 0;
                         for_each_partner(law, grains, nearest, i,
                                          [&](const PairForce& of, double over, const Vec3& separation) {
                                            sum.x += rounded_to_integer(per_force * over * separation.x),
                                                sum.y += rounded_to_integer(per_force * over * separation.y);
                                            sum.z += rounded_to_integer(per_force * over * separation.z);
                                            half += rounded_to_integer(per_energy * of.energy);
                                          });
                         force[i] = sum;
                         return half;
                       },
                       [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(energy, sum); });
  }

 private:
  const Executor* run_;
  Law law_;
  PairGeometry strongest_;
};

/// Makes a PairPart whose kernels run on a CUDA device. CMake's add_law_kernels writes a file that instantiates this
/// function with nvcc. In builds without CUDA the file defines a specialization that returns null.
template <PairLaw Law>
std::unique_ptr<DevicePart> make_cuda_part(const parallel::CudaExecutor& run, const Law& law,
                                           const PairGeometry& strongest)
#ifdef __CUDACC__
{
  return std::make_unique<PairPart<Law, parallel::CudaExecutor>>(run, law, strongest);
}
#else
    ;
#endif

}  // namespace lichtenberg
