#pragma once

#include <memory>

#include "solvers/laplace/cutcell/backend.hpp"
#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace::device {

/// Wall times and memory traffic of the parts of a CG iteration on the device, for performance measurements.
struct Profile {
  struct Traffic {
    double seconds = 0;
    /// Minimum traffic (bytes): each array's entries once per read and once per write.
    double bytes = 0;
  };
  /// Operator evaluation, V-cycle, and a copy from device to device for comparison.
  Traffic apply_operator, cycle, copy;
  int levels = 0;
  long coarse_unknowns = 0;
};

/// Cut-cell solver whose algorithm runs on a CUDA device (or on the CPU for comparison): conductances, multigrid,
/// iterations and results. The host sends the bodies and fetches the results by body and group (bodies with one
/// potential).
class DeviceSolver : public CutCellBackend {
 public:
  using CutCellBackend::CutCellBackend;
  /// Measures the times of the parts of an iteration on the last solve's grids, averaged over `repeats`. Discards the
  /// history.
  virtual Profile profile(int repeats) = 0;
};

/// Makes a solver on PETSc's CUDA device, or on several (CutCellOptions::cuda_devices). Throws InputError without such
/// devices, for a list of one device, or without CUDA in the build; for several also without NCCL.
std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options);

/// Makes a solver that runs the device's algorithm on the CPU, for comparison. `ranks`: number of devices that threads
/// of the CPU represent; several divide grids of at least 1024 cells each.
std::unique_ptr<DeviceSolver> make_host_solver(const CutCellOptions& options, int ranks = 1);

}  // namespace lichtenberg::laplace::device
