#pragma once

#include <cmath>

namespace lichtenberg::laplace {

/// Cost model of a field solver: memory and time per unknown on one core or on a CUDA device. On grids an unknown is a
/// cell, including cells under conductors. The values are measured (docs/measurements/explain.json); machines differ by
/// factors of two and more.
struct CostModel {
  double bytes = 0;                ///< Memory per unknown (bytes)
  double setup = 0;                ///< Time of the setup per unknown (s)
  double iteration = 0;            ///< Time of an iteration per unknown (s)
  double iterations_a_decade = 0;  ///< Iterations per decade of the tolerance
  double start = 0;                ///< Fixed cost of a solve (s)
  double start_of_iteration = 0;   ///< Fixed cost of an iteration (s)

  /// Returns the predicted time (s) of a solve with this number of unknowns and relative tolerance.
  /// `share_of_iterations`: fraction of the iterations that is needed, such as with a good initial guess.
  double seconds(double unknowns, double tolerance, double share_of_iterations = 1) const {
    const double iterations = share_of_iterations * iterations_a_decade * -std::log10(tolerance);
    return start + unknowns * setup + iterations * (start_of_iteration + unknowns * iteration);
  }
};

// Cost models of the field methods: cut-cell method on the CPU, on a CUDA device, and with an assembled matrix;
// multipole
// method for disks; solid harmonics for spheres.
constexpr CostModel cut_cell_cost{100, 2.5e-8, 8.5e-9, 1.25};
constexpr CostModel cut_cell_cost_on_device{200, 1.3e-10, 1.5e-10, 1.5, 6e-4, 3.3e-4};
constexpr CostModel assembled_cost{373, 1.3e-6, 4.5e-8, 2.25};
constexpr CostModel multipole_cost{2000, 1.5e-6, 1.8e-7, 3};
constexpr CostModel spheres_cost{800, 5e-7, 4e-7, 3};

}  // namespace lichtenberg::laplace
