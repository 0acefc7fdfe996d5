#pragma once

#include <memory>

#include "solvers/laplace/cutcell/backend.hpp"
#include "solvers/laplace/cutcell/solver.hpp"

namespace lichtenberg::laplace::device {

/// What the two parts of an iteration cost.
struct Profile {
  struct Part {
    double seconds = 0;
    /// Bytes that it must move: each array's entries once where they are read and once where they are written.
    double bytes = 0;
  };
  Part apply_operator, cycle, copy;  ///< copy: device to device
  int levels = 0;
  long coarse_unknowns = 0;
};

/// The cut-cell solver with everything on an executor's device: links, grids, Krylov iterations and results. Only the
/// bodies go there and only what belongs to a body or a group comes back.
class DeviceSolver : public CutCellBackend {
 public:
  using CutCellBackend::CutCellBackend;
  /// Times the parts on the last solve's grids.
  virtual Profile profile(int repeats) = 0;
};

/// On the CUDA device that PETSc uses. Throws InputError if there is none, or if the program was built without CUDA.
std::unique_ptr<DeviceSolver> make_cuda_solver(const CutCellOptions& options);

/// The device's algorithm run by the CPU, for comparison.
std::unique_ptr<DeviceSolver> make_host_solver(const CutCellOptions& options);

}  // namespace lichtenberg::laplace::device
