#include "solvers/parallel/cuda_executor.hpp"
#include "src/effects/uniform_force.hpp"
#include "src/effects/wind.hpp"
#include "src/granular/device/gas.hpp"
#include "src/model/drive_part.hpp"

template std::unique_ptr<lichtenberg::DeviceDrive> lichtenberg::make_cuda_drive<lichtenberg::effects::Wind>(
    const lichtenberg::parallel::CudaExecutor&, const lichtenberg::effects::Wind&);
template std::unique_ptr<lichtenberg::DeviceDrive> lichtenberg::make_cuda_drive<lichtenberg::effects::UniformPush>(
    const lichtenberg::parallel::CudaExecutor&, const lichtenberg::effects::UniformPush&);

namespace lichtenberg::granular::device {

std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene) {
  check_scene(scene);
  parallel::require_cuda_device();
  return std::make_unique<GasImpl<parallel::CudaExecutor>>(std::make_unique<parallel::CudaExecutor>(),
                                                           gas_options(scene));
}

}  // namespace lichtenberg::granular::device
