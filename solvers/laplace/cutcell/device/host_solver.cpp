#include "solvers/laplace/cutcell/device/cutcell.hpp"
#include "solvers/laplace/cutcell/device/host_executor.hpp"

namespace lichtenberg::laplace::device {

std::unique_ptr<DeviceSolver> make_host_solver(const CutCellOptions& options) {
  start_petsc();
  return std::make_unique<CutCell<HostExecutor>>(options);
}

#ifndef LICHTENBERG_WITH_CUDA
std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions&) {
  throw InputError("device = \"cuda\": this program was built without CUDA; configure it with -DLICHTENBERG_CUDA=ON");
}
#endif

}  // namespace lichtenberg::laplace::device
