#pragma once

#include <cmath>

namespace lichtenberg::laplace {

/// Cost model of a solve per unknown (for grids: per cell, including those under conductors), on one core or on a
/// device. The values are measured (docs/measurements/explain.json). Machines differ by factors of two and more.
struct CostModel {
  double bytes = 0;
  double setup = 0;                ///< Setup (s)
  double iteration = 0;            ///< Iteration (s)
  double iterations_a_decade = 0;  ///< Iterations per decade of the tolerance
  double start = 0;                ///< Fixed cost of a solve (s)
  double start_of_iteration = 0;   ///< Fixed cost of an iteration (s)

  /// Returns the time (s) of a solve with this many unknowns.
  double seconds(double unknowns, double tolerance, double share_of_iterations = 1) const {
    const double iterations = share_of_iterations * iterations_a_decade * -std::log10(tolerance);
    return start + unknowns * setup + iterations * (start_of_iteration + unknowns * iteration);
  }
};

constexpr CostModel cut_cell_cost{100, 2.5e-8, 8.5e-9, 1.25};
constexpr CostModel cut_cell_cost_on_device{200, 1.3e-10, 1.5e-10, 1.5, 6e-4, 3.3e-4};
constexpr CostModel assembled_cost{373, 1.3e-6, 4.5e-8, 2.25};
constexpr CostModel multipole_cost{2000, 1.5e-6, 1.8e-7, 3};
constexpr CostModel spheres_cost{800, 5e-7, 4e-7, 3};

}  // namespace lichtenberg::laplace
