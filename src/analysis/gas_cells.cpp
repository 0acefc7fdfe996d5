#include "src/analysis/gas_cells.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::analysis {

int Cells::of(std::span<const double> place) const {
  int cell = 0;
  for (int k = dimension - 1; k >= 0; --k)
    cell = cell * count[k] + std::clamp(static_cast<int>(place[k] / edge[k]), 0, count[k] - 1);
  return cell;
}

int Cells::next(int cell, int axis) const {
  const int stride = axis == 0 ? 1 : axis == 1 ? count[0] : count[0] * count[1];
  const bool last = cell / stride % count[axis] == count[axis] - 1;
  return last ? cell - stride * (count[axis] - 1) : cell + stride;
}

Cells cells_of(const Bodies& bodies, double edge) {
  Cells cells{.dimension = bodies.dimension};
  double space = 1;
  for (int k = 0; k < bodies.dimension; ++k) space *= bodies.box.lengths[k];
  const double most = std::max(1e6, 64.0 * bodies.size());
  edge = std::max(edge, std::pow(space / most, 1.0 / bodies.dimension));
  for (int k = 0; k < bodies.dimension; ++k) {
    cells.count[k] = std::max(1, static_cast<int>(std::lround(bodies.box.lengths[k] / edge)));
    cells.edge[k] = bodies.box.lengths[k] / cells.count[k];
  }
  return cells;
}

std::vector<int> cell_of_each(const Bodies& bodies, const Cells& cells) {
  const std::span<const double> places = bodies.position;
  std::vector<int> cell(bodies.size());
  for (int i = 0; i < bodies.size(); ++i) cell[i] = cells.of(places.subspan(i * bodies.dimension, bodies.dimension));
  return cell;
}

}  // namespace lichtenberg::analysis
