#include "solvers/laplace/cutcell/device/cutcell.hpp"
#include "solvers/parallel/host_executor.hpp"

namespace lichtenberg::laplace::device {

template <>
struct PetscSide<parallel::HostExecutor> {
  static constexpr const char *vector_type = VECSEQ, *method = "device_cg_on_host";
  static std::unique_ptr<parallel::HostExecutor> make() { return std::make_unique<parallel::HostExecutor>(); }
};

std::unique_ptr<DeviceSolver> make_host_solver(const CutCellOptions& options, int ranks) {
  using parallel::HostExecutor;
  if (ranks == 1) return std::make_unique<CutCell<HostExecutor>>(options);
  return std::make_unique<CutCell<HostExecutor>>(
      options, SeveralDevices<HostExecutor>{{parallel::host_links(ranks), [](int) {}},
                                            [](auto link) { return std::make_unique<HostExecutor>(std::move(link)); },
                                            1L << 10});
}

#ifndef LICHTENBERG_WITH_CUDA
std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions&) {
  throw InputError("device = \"cuda\": this program was built without CUDA; configure it with -DLICHTENBERG_CUDA=ON");
}
#endif

}  // namespace lichtenberg::laplace::device
