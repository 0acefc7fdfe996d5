#pragma once

#include <memory>

#include "solvers/laplace/cutcell/backend.hpp"
#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace::device {

/// Times of the two parts of an iteration.
struct Profile {
  struct Part {
    double seconds = 0;
    /// Minimum traffic (bytes): each array's entries once per read and once per write.
    double bytes = 0;
  };
  Part apply_operator, cycle, copy;  ///< copy: device to device
  int levels = 0;
  long coarse_unknowns = 0;
};

/// Cut-cell solver on an executor's device: links, grids, iterations and results. The host sends the bodies and fetches
/// the results by body and group.
class DeviceSolver : public CutCellBackend {
 public:
  using CutCellBackend::CutCellBackend;
  /// Times the parts on the last solve's grids.
  virtual Profile profile(int repeats) = 0;
};

/// Makes a solver on PETSc's CUDA device. Throws InputError without such a device, or without CUDA in the build.
std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options);

/// Makes a solver that runs the device's algorithm on the CPU, for comparison.
std::unique_ptr<DeviceSolver> make_host_solver(const CutCellOptions& options);

}  // namespace lichtenberg::laplace::device
