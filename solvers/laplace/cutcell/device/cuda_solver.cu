#include "solvers/laplace/cutcell/device/cuda_executor.hpp"
#include "solvers/laplace/cutcell/device/cutcell.hpp"

namespace lichtenberg::laplace::device {

std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options) {
  int count = 0;
  const cudaError_t code = cudaGetDeviceCount(&count);
  if (code != cudaSuccess || count == 0)
    throw InputError(std::string("device = \"cuda\": this machine has no CUDA device that can be used (") +
                     cudaGetErrorString(code == cudaSuccess ? cudaErrorNoDevice : code) + ")");
  start_petsc();
  return std::make_unique<CutCell<CudaExecutor>>(options);
}

}  // namespace lichtenberg::laplace::device
