#include "src/analysis/gas_temperature.hpp"

#include "src/analysis/gas_cells.hpp"

namespace lichtenberg::analysis {
namespace {

/// Mass, momentum and number of grains of each cell.
struct Flow {
  std::vector<double> mass, momentum;  ///< [cells], [cells * d]
  std::vector<int> grains;             ///< [cells]
};

Flow flow_in(const Bodies& b, const std::vector<int>& cell, int cells) {
  Flow flow{std::vector<double>(cells), std::vector<double>(cells * b.dimension), std::vector<int>(cells)};
  for (int i = 0; i < b.size(); ++i) {
    flow.mass[cell[i]] += b.mass[i];
    ++flow.grains[cell[i]];
    for (int k = 0; k < b.dimension; ++k) flow.momentum[cell[i] * b.dimension + k] += b.momentum[i * b.dimension + k];
  }
  return flow;
}

/// sum m (v - V)^2, V the mean of the cell; without the flow all of sum m v^2. In two passes: late in a run flow is
/// thousands of times faster than what is left of it.
double squares(const Bodies& b, const std::vector<int>& cell, const Flow* flow) {
  double sum = 0;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < b.dimension; ++k) {
      const double mean = flow ? flow->momentum[cell[i] * b.dimension + k] / flow->mass[cell[i]] : 0;
      const double speed = b.momentum[i * b.dimension + k] / b.mass[i] - mean;
      sum += b.mass[i] * speed * speed;
    }
  return sum;
}

}  // namespace

GranularTemperature granular_temperature(const Bodies& bodies, double edge) {
  GranularTemperature found;
  if (bodies.size() == 0) return found;
  const Cells cells = cells_of(bodies, edge);
  const std::vector<int> cell = cell_of_each(bodies, cells);
  const Flow flow = flow_in(bodies, cell, cells.size());
  int free = 0;  // grains beyond the first of their cell
  for (const int grains : flow.grains) free += std::max(grains - 1, 0);
  if (free > 0) found.local = squares(bodies, cell, &flow) / (bodies.dimension * static_cast<double>(free));
  found.total = squares(bodies, cell, nullptr) / (bodies.dimension * static_cast<double>(bodies.size()));
  return found;
}

}  // namespace lichtenberg::analysis
