#include <petscdevice_cuda.h>

#include "solvers/laplace/cutcell/device/cutcell.hpp"
#include "solvers/parallel/cuda_executor.hpp"

namespace lichtenberg::laplace::device {

template <>
struct PetscSide<parallel::CudaExecutor> {
  static constexpr const char *vector_type = VECSEQCUDA, *method = "device_cg";
  static std::unique_ptr<parallel::CudaExecutor> make() {
    parallel::check_petsc(PetscDeviceInitialize(PETSC_DEVICE_CUDA));
    cudaStream_t stream = nullptr;
    parallel::check_petsc(PetscGetCurrentCUDAStream(&stream));
    return std::make_unique<parallel::CudaExecutor>(stream, parallel::KernelStart::early);
  }
};

std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options) {
  parallel::require_cuda_device();
  return std::make_unique<CutCell<parallel::CudaExecutor>>(options);
}

}  // namespace lichtenberg::laplace::device
