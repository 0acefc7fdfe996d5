#include "solvers/parallel/cuda_executor.hpp"
#include "src/granular/device/ranks.hpp"

namespace lichtenberg::granular::device {

int cuda_device_count() { return parallel::cuda_device_count(); }

std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene, const std::vector<int>& devices) {
  using parallel::CudaExecutor;
  check_scene(scene, Target::cuda, static_cast<int>(devices.size()));
  parallel::cuda_devices(devices);
  const auto enter = [devices](int rank) { parallel::check_cuda(cudaSetDevice(devices[rank])); };
  if (devices.size() > 1)
    return std::make_unique<GasOnRanks<CudaExecutor>>(
        parallel::cuda_links(devices), enter,
        [](auto link) {
          return std::make_unique<CudaExecutor>(nullptr, parallel::KernelStart::in_turn, std::move(link));
        },
        gas_options(scene));
  if (!devices.empty()) enter(0);
  return std::make_unique<GasImpl<CudaExecutor>>(std::make_unique<CudaExecutor>(), gas_options(scene));
}

}  // namespace lichtenberg::granular::device
