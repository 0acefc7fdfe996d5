// Error decay of the approximate gradient descent (D 6.30, 6.38; figure 6.6): two disks, d / 2R = 4, eta = 0.01, eps =
// 1, in the source's insulated box of S = 512 sites with R = 7.75 spacings; the left disk at 0 V, the right one with
// charge 1. Prints capacitances and rates as comments, then "iteration error", E of D 6.22.
//
//   error_decay
//   error_decay

#include <fmt/format.h>

#include "solvers/laplace/relaxation/solver.hpp"
#include "validation/theory/two_disks.hpp"

using namespace lichtenberg;
using namespace lichtenberg::laplace;

int main() {
  constexpr int sites = 512;
  constexpr double radius = 7.75, ratio = 4, eta = 0.01, charge = 1;
  const Vec2 middle = {0.5 * sites, 0.5 * sites}, half = {radius * ratio, 0};
  const theory::DiskPair pair = {{middle + half, radius}, {middle - half, radius}, 1};

  LaplaceProblem problem{.permittivity = 1};
  problem.size = {sites, sites};
  problem.bodies = {{pair.negative, 0}, {pair.positive, 1}};
  problem.groups = {{.floating = false, .potential = 0}, {.charge = charge}};
  RelaxationSolver solver({.sites = sites, .eta = eta});
  const LaplaceSolution solution = solver.solve(problem);

  const double capacitance = charge / solution.group_potential[1];
  fmt::print("# capacitance computed {:.6f}, in the plane (D 6.37) {:.6f}\n", capacitance, theory::capacitance(pair));
  fmt::print("# small-step rate 2 eta C22 (D 6.39): {:.6f}\n", theory::small_step_decay_rate(eta, capacitance));
  fmt::print("# exact rate -2 ln(1 - eta C22): {:.6f}\n", theory::error_decay_rate(eta, capacitance));
  for (std::size_t n = 0; n < solver.error_history().size(); ++n)
    fmt::print("{} {:.9e}\n", n, solver.error_history()[n]);
}
