#include "solvers/laplace/cutcell/device/cuda_executor.hpp"
#include "solvers/laplace/cutcell/device/cutcell.hpp"

namespace lichtenberg::laplace::device {

std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options) {
  int count = 0;
  const cudaError_t code = cudaGetDeviceCount(&count);
  if (code != cudaSuccess || count == 0)
    throw InputError(std::string("device = \"cuda\": this machine has no CUDA device that can be used (") +
                     cudaGetErrorString(code == cudaSuccess ? cudaErrorNoDevice : code) + ")");
  check_cuda(cudaFree(nullptr));
  start_petsc();
  // CUDA's memory is to outlive PETSc's vectors, also if PETSc was there first.
  static const bool ended_before_cuda = std::atexit(finish_petsc) == 0;
  if (!ended_before_cuda) throw Failure("the end of PETSc could not be arranged for");
  return std::make_unique<CutCell<CudaExecutor>>(options);
}

}  // namespace lichtenberg::laplace::device
