// Newton's third law: the forces on the bodies and the reaction of the box's sides add up to zero. The force on the
// sides is the Maxwell stress of the computed potential; that on the bodies follows from virtual work. The two are
// computed independently, so their sum must decrease with h^2.
//
//   force_balance         S = 64, 128, 256, 512
//   force_balance long    to S = 2048

#include <functional>

#include "solvers/laplace/cutcell/solver.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace force_balance_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

/// Returns five disks of different size and charge at asymmetric positions in the unit box with one grounded side.
LaplaceProblem scene() {
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {1, 1};
  problem.sides[bottom].kind = Side::Kind::electrode;
  problem.bodies = {{Disk{{0.23, 0.31}, 0.09}, 0},
                    {Disk{{0.61, 0.22}, 0.07}, 1},
                    {Disk{{0.71, 0.63}, 0.12}, 2},
                    {Disk{{0.33, 0.71}, 0.1}, 3},
                    {Disk{{0.47, 0.47}, 0.06}, 4}};
  problem.groups = {{.charge = 1}, {.charge = -0.6}, {.charge = 0.8}, {.charge = 0.3}, {.charge = -0.2}};
  return problem;
}

/// Returns the force on one side of the box along its inward normal, the integral of E_n^2 / 2 or -E_t^2 / 2 (eps = 1).
/// The field is normal to an electrode and tangential to an insulating side.
///
/// `at(k, depth)` is the potential of cell k along the side, `depth` cells inside. The normal field at an electrode of
/// potential 0 follows from the first two cell centres, at d = h/2 and 3h/2. There V = a d + b d^3, because V'' = 0
/// along a side of constant potential. Hence a = (27 V0 - V1) / 12h, with a truncation error of h^4. On an insulating
/// side V = V0 + (V0 - V1) / 8 at the wall, from V = c + b d^2, and the tangential field is its central difference.
double inward_force(const std::function<double(int, int)>& at, int cells, double h, bool electrode) {
  const auto wall = [&](int k) { return at(k, 0) + (at(k, 0) - at(k, 1)) / 8; };
  double sum = 0;
  for (int k = 0; k < cells; ++k) {
    if (electrode) {
      const double normal = (27 * at(k, 0) - at(k, 1)) / (12 * h);
      sum += 0.5 * h * normal * normal;
    } else {
      const int before = std::max(k - 1, 0), after = std::min(k + 1, cells - 1);
      const double tangential = (wall(after) - wall(before)) / ((after - before) * h);
      sum -= 0.5 * h * tangential * tangential;
    }
  }
  return sum;
}

/// Returns the force of the field on the four sides (N/m). It attracts electrodes into the field and repels insulating
/// sides.
Vec2 force_on_sides(const LaplaceProblem& problem, const Field& field) {
  const int n = field.nx;
  const auto value = [&](int i, int j) { return field.value[j * n + i]; };
  const Vec2 inward[] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  const std::function<double(int, int)> along[] = {
      [&](int k, int depth) { return value(depth, k); }, [&](int k, int depth) { return value(n - 1 - depth, k); },
      [&](int k, int depth) { return value(k, depth); }, [&](int k, int depth) { return value(k, n - 1 - depth); }};
  Vec2 force;
  for (int side = 0; side < 4; ++side) {
    const bool electrode = problem.sides[side].kind == Side::Kind::electrode;
    force += inward_force(along[side], n, field.h, electrode) * inward[side];
  }
  return force;
}

}  // namespace

int validate(int argc, char** argv) {
  const LaplaceProblem problem = scene();
  const std::vector<double> sizes = long_run_requested(argc, argv) ? std::vector<double>{64, 128, 256, 512, 1024, 2048}
                                                                   : std::vector<double>{64, 128, 256, 512};
  Report report("Sum of the forces on bodies and sides");
  report.section("% of the largest force");
  std::vector<double> sum;
  for (const double cells : sizes) {
    CutCellSolver solver({.cells = static_cast<int>(cells), .tolerance = 1e-10});
    const LaplaceSolution solution = solver.solve(problem);
    Vec2 total = force_on_sides(problem, solver.field());
    double largest = 0;
    for (const Vec2 force : solution.body_force) {
      total += force;
      largest = std::max(largest, norm(force));
    }
    sum.push_back(100 * norm(total) / largest);
    // For disks with radii of some 30 cells at S = 512, the forces are accurate to 0.05 % (reference_disks).
    report.at_most(fmt::format("S = {}", cells), sum.back(), cells == 512 ? std::optional(0.05) : std::nullopt);
  }
  report.at_least("order", order(sizes, sum), 1.7);
  return report.exit_status();
}

const lichtenberg::validation::Program program("force_balance", validate);

}  // namespace force_balance_validation
