#include <cmath>

#include "solvers/laplace/relaxation/solver.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg {

const FieldMethodKind& relaxation_method() {
  static const FieldMethodKind kind = {
      .name = "relaxation",
      .help =
          "successive over-relaxation on a lattice, with gradient descent to the given charges (Stephenson 2018, "
          "equations 6.3 to 6.5)",
      .describe =
          [](const FieldOptions&) {
            return std::string(
                "relaxation (D 6.3-6.5): over-relaxed lattice, gradient descent on the floating potentials");
          },
      .make = [](const FieldOptions& options) -> std::unique_ptr<laplace::LaplaceSolver> {
        return std::make_unique<laplace::RelaxationSolver>(laplace::RelaxationOptions{
            .sites = options.cells, .eta = options.relaxation_eta, .tolerance = options.tolerance});
      },
      // The number of sweeps of over-relaxation is proportional to the lattice side (D 6.9), and so is the time of an
      // iteration.
      .cost =
          [](const FieldOptions& options) {
            return FieldMethodCost{laplace::CostModel{16, 0, 3.5e-10 * options.cells, 60}};
          },
      // The integrals around the bodies have errors of this size. The discretization error is a hundred times the
      // default tolerance.
      .tolerance = {.single = 1e-4, .moving = 1e-4, .least = 1e-10},
      .on_grid = true,
      // The scheme fixes a conductor's potential at the sites inside it (D 6.3). A disk contains a site at any position
      // if its radius is at least half a cell diagonal.
      .least_radius = std::sqrt(0.5)};
  return kind;
}

}  // namespace lichtenberg
