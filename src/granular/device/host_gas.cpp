#include "solvers/parallel/host_executor.hpp"
#include "src/granular/device/ranks.hpp"

namespace lichtenberg::granular::device {

std::unique_ptr<DeviceGas> make_host_gas(const Scene& scene, int ranks) {
  check_scene(scene, Target::host, ranks);
  if (ranks > 1)
    return std::make_unique<GasOnRanks<parallel::HostExecutor>>(
        parallel::host_links(ranks), [](int) {},
        [](auto link) { return std::make_unique<parallel::HostExecutor>(std::move(link)); }, gas_options(scene));
  return std::make_unique<GasImpl<parallel::HostExecutor>>(std::make_unique<parallel::HostExecutor>(),
                                                           gas_options(scene));
}

#ifndef LICHTENBERG_WITH_CUDA
std::unique_ptr<DeviceGas> make_cuda_gas(const Scene& scene, const std::vector<int>& devices) {
  check_scene(scene, Target::cuda, static_cast<int>(devices.size()));
  cuda_device_count();
  return nullptr;
}
int cuda_device_count() {
  throw InputError("device = \"cuda\": this program was built without CUDA; configure it with -DLICHTENBERG_CUDA=ON");
}
#endif

}  // namespace lichtenberg::granular::device
