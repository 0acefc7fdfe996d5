#include "solvers/parallel/host_executor.hpp"
#include "solvers/periodic/device/charges.hpp"

namespace lichtenberg::periodic::device {

std::unique_ptr<DeviceMesh> make_host_mesh(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure) {
  return std::make_unique<DeviceMeshOn<parallel::HostExecutor>>(std::make_unique<parallel::HostExecutor>(),
                                                                make_tables(mesh, cloud, enclosure));
}

#ifndef LICHTENBERG_WITH_CUDA
std::unique_ptr<DeviceMesh> make_cuda_mesh(const Mesh&, const Cloud&, const Enclosure&) {
  throw InputError("device \"cuda\": this program was built without CUDA; configure it with -DLICHTENBERG_CUDA=ON");
}
#endif

}  // namespace lichtenberg::periodic::device
