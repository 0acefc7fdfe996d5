#pragma once

// Device implementation of Effect::drive for a law that acts on each grain separately.

#include <memory>

#ifdef __CUDACC__
#include "solvers/parallel/cuda_executor.hpp"
#endif
#include "solvers/parallel/host_executor.hpp"
#include "src/model/device_part.hpp"

namespace lichtenberg {

/// Device implementation of Effect::drive for a law that acts on each grain separately, in reduced units. The law is a
/// small struct for the host and for a device with
///
/// ```
///     void operator()(double time, double dt, int number, double mass, double* momentum, int dimension) const
/// ```
///
/// which changes the momentum ([dimension]) of one grain from `time` to `time` + dt. `number` is the index of the grain
/// in the scene.
template <class Law, class Executor>
class DrivePart final : public DeviceDrive {
 public:
  DrivePart(const Executor& run, const Law& law) : run_(&run), law_(law) {}

  void drive(const DeviceGrains& grains, double time, double dt, Vec3* momentum, double quantum,
             std::int64_t* driven) const override {
    constexpr int a_part = 32;
    const Law law = law_;
    const double* inverse_mass = grains.inverse_mass;
    const int *number = grains.number, n = grains.count;
    run_->sum_segments(
        (n + a_part - 1) / a_part,
        [=] LICHTENBERG_HOST_DEVICE(int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; },
        [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
          const int s = p * a_part + t;
          const Vec3 before = momentum[s];
          double after[3] = {before.x, before.y, before.z};
          law(time, dt, number[s], 1 / inverse_mass[s], after, 3);
          momentum[s] = {after[0], after[1], after[2]};
          return rounded_to_integer(0.5 * inverse_mass[s] * (norm2(momentum[s]) - norm2(before)) / quantum);
        },
        [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(driven, sum); });
  }

 private:
  const Executor* run_;
  Law law_;
};

/// Makes a DrivePart whose kernels run on a CUDA device. CMake's add_law_kernels writes a file that instantiates this
/// function with nvcc. In builds without CUDA the file defines a specialization that returns null.
template <class Law>
std::unique_ptr<DeviceDrive> make_cuda_drive(const parallel::CudaExecutor& run, const Law& law)
#ifdef __CUDACC__
{
  return std::make_unique<DrivePart<Law, parallel::CudaExecutor>>(run, law);
}
#else
    ;
#endif

/// Returns a factory of the DrivePart of a law for the CPU only; `make_on_cuda` is empty.
template <class Law>
DeviceForm<DeviceDrive> drive_form(const Law& law) {
  DeviceForm<DeviceDrive> form;
  form.make_on_host = [=](const parallel::HostExecutor& run) {
    return std::make_unique<DrivePart<Law, parallel::HostExecutor>>(run, law);
  };
  return form;
}

/// Returns a factory of the DrivePart of a law for the CPU and for a CUDA device. CMake's add_law_kernels must add the
/// kernels to the target; otherwise the target does not link, even in builds without CUDA.
template <class Law>
DeviceForm<DeviceDrive> drive_form_with_kernels(const Law& law) {
  DeviceForm<DeviceDrive> form = drive_form(law);
  form.make_on_cuda = [=](const parallel::CudaExecutor& run) { return make_cuda_drive<Law>(run, law); };
  return form;
}

}  // namespace lichtenberg
