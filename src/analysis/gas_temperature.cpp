#include "src/analysis/gas_temperature.hpp"

#include "src/analysis/gas_cells.hpp"

namespace lichtenberg::analysis {
namespace {

/// Velocity and number of grains of each occupied cell.
struct Flow {
  std::vector<double> velocity;  ///< [cells * d], mass-weighted mean
  std::vector<int> grains;       ///< [cells]
};

Flow flow_in(const Bodies& b, const std::vector<int>& cell, int cells) {
  std::vector<double> mass(cells);
  Flow flow{std::vector<double>(cells * b.dimension), std::vector<int>(cells)};
  for (int i = 0; i < b.size(); ++i) {
    mass[cell[i]] += b.mass[i];
    ++flow.grains[cell[i]];
    for (int k = 0; k < b.dimension; ++k) flow.velocity[cell[i] * b.dimension + k] += b.momentum[i * b.dimension + k];
  }
  for (int c = 0; c < cells; ++c)
    for (int k = 0; k < b.dimension; ++k) flow.velocity[c * b.dimension + k] /= mass[c];
  return flow;
}

/// sum m (v - V)^2, V the mean of the cell, and sum m v^2. Two passes avoid cancellation, because late in a run the
/// flow can be thousands of times faster than the relative motion.
struct Squares {
  double local = 0, total = 0;
};

Squares squares(const Bodies& b, const std::vector<int>& cell, const Flow& flow) {
  Squares sum;
  for (int i = 0; i < b.size(); ++i) {
    const double *p = &b.momentum[i * b.dimension], *mean = &flow.velocity[cell[i] * b.dimension];
    for (int k = 0; k < b.dimension; ++k) {
      const double v = p[k] / b.mass[i], local = v - mean[k];
      sum.local += b.mass[i] * local * local;
      sum.total += b.mass[i] * v * v;
    }
  }
  return sum;
}

}  // namespace

GranularTemperature granular_temperature(const Bodies& bodies, double edge) {
  GranularTemperature found;
  if (bodies.size() == 0) return found;
  const Cells cells = cells_of(bodies, edge);
  const OccupiedCells occupied = occupied_cells(bodies, cells);
  const Flow flow = flow_in(bodies, occupied.body_cell, occupied.size());
  int free = 0;  // number of grains minus number of occupied cells
  for (const int grains : flow.grains) free += std::max(grains - 1, 0);
  const Squares sum = squares(bodies, occupied.body_cell, flow);
  if (free > 0) found.local = sum.local / (bodies.dimension * static_cast<double>(free));
  found.total = sum.total / (bodies.dimension * static_cast<double>(bodies.size()));
  return found;
}

}  // namespace lichtenberg::analysis
