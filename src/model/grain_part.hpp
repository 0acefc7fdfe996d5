#pragma once

// Force of an external field on each grain separately (a law of one grain) on a device.

#include <memory>

#ifdef __CUDACC__
#include "solvers/parallel/cuda_executor.hpp"
#endif
#include "solvers/parallel/host_executor.hpp"
#include "src/model/device_part.hpp"

namespace lichtenberg {

/// Forces of an external field on charges of grains on a device, in reduced units. The law is a small struct for the
/// host and for a device with
///
/// ```
///     double force(double charge, int k) const
///     double energy(double charge, double coordinate, int k) const
/// ```
///
/// which return component k of the force, and the contribution of axis k to the energy. Along periodic axes the
/// coordinate is unwrapped.
template <class Law, class Executor>
class GrainPart final : public DevicePart {
 public:
  /// Makes the forces of a law. `size`: about the largest force on a grain, and the largest energy.
  GrainPart(const Executor& run, const Law& law, const PairUnits& size) : run_(&run), law_(law), size_(size) {}

  PairUnits size() const override { return size_; }

  void add_forces(const DeviceGrains& grains, const PairUnits& units, FixedPointVec* force,
                  std::int64_t* energy) const override {
    constexpr int a_part = 32;
    const Law law = law_;
    const int n = grains.count;
    const double per_force = 1 / units.force, per_energy = 1 / units.energy;
    run_->sum_segments((n + a_part - 1) / a_part,
                       [=] LICHTENBERG_HOST_DEVICE(int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
                         const int s = p * a_part + t;
                         const double charge = grains.charge[s];
                         force[s].x += rounded_to_integer(per_force * law.force(charge, 0));
                         force[s].y += rounded_to_integer(per_force * law.force(charge, 1));
                         force[s].z += rounded_to_integer(per_force * law.force(charge, 2));
                         double stored = 0;
                         for (int k = 0; k < 3; ++k)
                           stored += law.energy(
                               charge, grains.position[s][k] + grains.image[3 * s + k] * grains.box.lengths[k], k);
                         return rounded_to_integer(per_energy * stored);
                       },
                       [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(energy, sum); });
  }

 private:
  const Executor* run_;
  Law law_;
  PairUnits size_;
};

/// Makes a GrainPart whose kernels run on a CUDA device. CMake's add_law_kernels writes a file that instantiates this
/// function with nvcc. In builds without CUDA the file defines a specialization that returns null.
template <class Law>
std::unique_ptr<DevicePart> make_cuda_grain_part(const parallel::CudaExecutor& run, const Law& law,
                                                 const PairUnits& size)
#ifdef __CUDACC__
{
  return std::make_unique<GrainPart<Law, parallel::CudaExecutor>>(run, law, size);
}
#else
    ;
#endif

/// Returns a factory of the GrainPart of a law for the CPU and for a CUDA device. CMake's add_law_kernels must add the
/// kernels to the target; otherwise the target does not link, even in builds without CUDA.
template <class Law>
DevicePartForm grain_form_with_kernels(const Law& law, const PairUnits& size) {
  DevicePartForm form;
  form.make_on_host = [=](const parallel::HostExecutor& run) {
    return std::make_unique<GrainPart<Law, parallel::HostExecutor>>(run, law, size);
  };
  form.make_on_cuda = [=](const parallel::CudaExecutor& run) { return make_cuda_grain_part<Law>(run, law, size); };
  return form;
}

}  // namespace lichtenberg
