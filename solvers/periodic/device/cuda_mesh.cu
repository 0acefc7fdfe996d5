#include "solvers/parallel/cuda_executor.hpp"
#include "solvers/periodic/device/charges.hpp"

namespace lichtenberg::periodic::device {

std::unique_ptr<DeviceMesh> make_cuda_mesh(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure) {
  parallel::require_cuda_device();
  return std::make_unique<DeviceMeshOn<parallel::CudaExecutor>>(std::make_unique<parallel::CudaExecutor>(),
                                                                make_tables(mesh, cloud, enclosure));
}

}  // namespace lichtenberg::periodic::device
