#include "solvers/parallel/cuda_executor.hpp"
#include "src/granular/device/gas.hpp"

namespace lichtenberg::granular::device {

std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene) {
  check_scene(scene);
  parallel::require_cuda_device();
  return std::make_unique<GasImpl<parallel::CudaExecutor>>(std::make_unique<parallel::CudaExecutor>(),
                                                           gas_options(scene));
}

}  // namespace lichtenberg::granular::device
