#include "solvers/parallel/host_executor.hpp"
#include "src/granular/device/gas.hpp"

namespace lichtenberg::granular::device {

std::unique_ptr<DeviceGas> make_host_gas(const Scene& scene) {
  check_scene(scene, Target::host);
  return std::make_unique<GasImpl<parallel::HostExecutor>>(std::make_unique<parallel::HostExecutor>(),
                                                           gas_options(scene));
}

#ifndef LICHTENBERG_WITH_CUDA
std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene) {
  check_scene(scene);
  throw InputError("device = \"cuda\": this program was built without CUDA; configure it with -DLICHTENBERG_CUDA=ON");
}
#endif

}  // namespace lichtenberg::granular::device
