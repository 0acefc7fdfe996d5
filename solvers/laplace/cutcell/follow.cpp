#include "solvers/laplace/cutcell/follow.hpp"

#include <cmath>

#include "solvers/laplace/cutcell/medium.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// Change of potentials on a grid of nx x ny cells, with a row and a column of mirror images around it.
struct Change {
  int nx, ny;
  std::vector<double> value;

  double& at(int i, int j) { return value[(j + 1) * (nx + 2) + i + 1]; }
  const double* row(int j) const { return &value[(j + 1) * (nx + 2) + 1]; }
};

/// Computes the change of the potentials from `before` to `now`, in units of `scale` (V). It is even about an
/// insulating side and odd about an electrode, whose potential does not change.
Change change_between(const Potentials& before, const Potentials& now, const LaplaceProblem& problem, double scale) {
  Change change{now.nx, now.ny, std::vector<double>((now.nx + 2) * (now.ny + 2))};
  const std::array<bool, 4> electrode = electrodes(problem);
  for (int j = -1; j <= now.ny; ++j)
    for (int i = -1; i <= now.nx; ++i) {
      const MirroredCell cell = MirroredCell::of(now.nx, now.ny, i, j, electrode.data());
      const int k = cell.j * now.nx + cell.i;
      change.at(i, j) = cell.sign * ((now.cell[k] - before.cell[k]) / scale);
    }
  return change;
}

/// Position of a finer grid's cell centre between two centres of a coarser grid.
struct InterpolationPoint {
  int low;
  double share_of_high;
};

InterpolationPoint interpolation_point(int fine, int fine_count, int coarse_count) {
  const double position = (fine + 0.5) * coarse_count / fine_count - 0.5, low = std::floor(position);
  return {static_cast<int>(low), position - low};
}

}  // namespace

void add_change(const Potentials& before, const Potentials& now, const LaplaceProblem& problem, double scale,
                const CutCellOperator& op, std::vector<double>& x) {
  const Change change = change_between(before, now, problem, scale);
  const Level& level = op.level();
  const Layout& at = level.layout;
  std::vector<InterpolationPoint> column;
  for (int i = 0; i < at.nx; ++i) column.push_back(interpolation_point(i, at.nx, change.nx));
  for_each_row(op.team(), at, [&](int j) {
    const auto [J, high] = interpolation_point(j, at.ny, change.ny);
    thread_local std::vector<double> line;
    line.resize(change.nx + 2);
    for (int I = -1; I <= change.nx; ++I) line[I + 1] = (1 - high) * change.row(J)[I] + high * change.row(J + 1)[I];
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = at.row(colour, j);
      const int parity = Layout::parity(colour, j);
      for (int k = 0; k < at.row_length(colour, j); ++k) {
        const auto [I, share] = column[2 * k + parity];
        const double value = (1 - share) * line[I + 1] + share * line[I + 2];
        x[row + k] += level.diagonal[row + k] > 0 ? value : 0.0;
      }
    }
  });
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[body.group];
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const int group = problem.bodies[body].group;
    if (problem.groups[group].floating)
      x[op.cells() + group] += (now.body[body] - before.body[body]) / (scale * members[group]);
  }
}

}  // namespace lichtenberg::laplace
