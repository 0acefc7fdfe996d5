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
  using parallel::CudaExecutor;
  std::vector<int> chosen;
  for (int k = 0; k < 64; ++k)
    if (options.cuda_devices >> k & 1) chosen.push_back(k);
  if (chosen.size() == 1)
    throw InputError("the list of CUDA devices has number " + std::to_string(chosen[0]) +
                     " only: a field needs several devices, all, or no list");
  const bool all = options.cuda_devices == CutCellOptions::all_cuda_devices;
  const std::vector<int> devices = parallel::cuda_devices(all ? std::vector{-1} : chosen);
  if (devices.size() < 2) return std::make_unique<CutCell<CudaExecutor>>(options);
  // Half of a grid of 4096 x 4096 cells: smaller shares save less time than the exchange of ghost rows takes.
  constexpr long least_cells = 1L << 23;
  return std::make_unique<CutCell<CudaExecutor>>(
      options, SeveralDevices<CudaExecutor>{
                   {parallel::cuda_links(devices),
                    [devices](int rank) { parallel::check_cuda(cudaSetDevice(devices[rank])); }},
                   [](auto link) {
                     return std::make_unique<CudaExecutor>(nullptr, parallel::KernelStart::in_turn, std::move(link));
                   },
                   least_cells});
}

}  // namespace lichtenberg::laplace::device
