#pragma once

// Device implementation of Effect::drive for a law that acts on each grain separately.

#include <memory>

#ifdef __CUDACC__
#include "solvers/parallel/cuda_executor.hpp"
#endif
#include "solvers/parallel/host_executor.hpp"
#include "src/model/device_part.hpp"

namespace lichtenberg {

/// A law is a small struct for the host and for a device, with
///
/// ```
///     void operator()(double time, double dt, int number, double mass, double* momentum, int dimension) const
/// ```
///
/// which changes the momentum ([dimension]) of one grain from `time` to `time` + dt.
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

/// Makes a drive with CUDA kernels. A file that CMake's add_law_kernels writes instantiates it with nvcc; in builds
/// without CUDA that file specializes it without kernels.
template <class Law>
std::unique_ptr<DeviceDrive> make_cuda_drive(const parallel::CudaExecutor& run, const Law& law)
#ifdef __CUDACC__
{
  return std::make_unique<DrivePart<Law, parallel::CudaExecutor>>(run, law);
}
#else
    ;
#endif

/// Returns the device form of a law, for the host executor.
template <class Law>
DeviceForm<DeviceDrive> drive_form(const Law& law) {
  DeviceForm<DeviceDrive> form;
  form.make_on_host = [=](const parallel::HostExecutor& run) {
    return std::make_unique<DrivePart<Law, parallel::HostExecutor>>(run, law);
  };
  return form;
}

/// Returns the device form of a law with CUDA kernels, which CMake's add_law_kernels adds to a target. A target without
/// them does not link, in builds without CUDA either.
template <class Law>
DeviceForm<DeviceDrive> drive_form_with_kernels(const Law& law) {
  DeviceForm<DeviceDrive> form = drive_form(law);
  form.make_on_cuda = [=](const parallel::CudaExecutor& run) { return make_cuda_drive<Law>(run, law); };
  return form;
}

}  // namespace lichtenberg
