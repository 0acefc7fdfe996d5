#include "solvers/parallel/cuda_executor.hpp"
#include "src/granular/device/ranks.hpp"

namespace lichtenberg::granular::device {

int cuda_device_count() {
  parallel::require_cuda_device();
  int count = 0;
  parallel::check_cuda(cudaGetDeviceCount(&count));
  return count;
}

std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene, const std::vector<int>& devices) {
  using parallel::CudaExecutor;
  check_scene(scene, Target::cuda, static_cast<int>(devices.size()));
  const int present = cuda_device_count();
  for (const int each : devices)
    if (each >= present)
      throw InputError("device \"cuda:" + std::to_string(each) + "\": this machine has " + std::to_string(present) +
                       " CUDA devices, numbered from 0");
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
