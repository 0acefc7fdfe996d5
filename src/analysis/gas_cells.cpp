#include "src/analysis/gas_cells.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::analysis {

std::int64_t Cells::index(std::span<const double> position) const {
  std::int64_t cell = 0;
  for (int k = dimension - 1; k >= 0; --k)
    cell = cell * count[k] + std::clamp(static_cast<int>((position[k] - corner[k]) / edge[k]), 0, count[k] - 1);
  return cell;
}

std::int64_t Cells::next(std::int64_t cell, int axis) const {
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? count[0] : std::int64_t{1} * count[0] * count[1];
  const bool last = cell / stride % count[axis] == count[axis] - 1;
  if (last && !periodic[axis]) return -1;
  return last ? cell - stride * (count[axis] - 1) : cell + stride;
}

Cells cells_of(const Bodies& bodies, double edge) {
  Cells cells{.dimension = bodies.dimension};
  Vec3 lengths = bodies.box.lengths;
  for (int k = 0; k < bodies.dimension; ++k)
    if (!(cells.periodic[k] = bodies.box.periodic(k))) {
      double high = lengths[k];
      for (int i = 0; i < bodies.size(); ++i) {
        const double x = bodies.position[i * bodies.dimension + k];
        cells.corner[k] = std::min(cells.corner[k], x), high = std::max(high, x);
      }
      lengths[k] = high - cells.corner[k];
    }
  constexpr double most = 1 << 20;  // limit along an axis, so that a cell's number fits in 64 bits
  for (int k = 0; k < bodies.dimension; ++k) edge = std::max(edge, lengths[k] / most);
  for (int k = 0; k < bodies.dimension; ++k) {
    cells.count[k] = std::max(1, static_cast<int>(std::lround(lengths[k] / edge)));
    cells.edge[k] = lengths[k] / cells.count[k];
  }
  return cells;
}

int OccupiedCells::find(std::int64_t wanted) const {
  const auto found = std::ranges::lower_bound(cell, wanted);
  return found != cell.end() && *found == wanted ? static_cast<int>(found - cell.begin()) : -1;
}

OccupiedCells occupied_cells(const Bodies& bodies, const Cells& cells) {
  const std::span<const double> positions = bodies.position;
  std::vector<std::int64_t> cell(bodies.size());
  for (int i = 0; i < bodies.size(); ++i)
    cell[i] = cells.index(positions.subspan(i * bodies.dimension, bodies.dimension));
  OccupiedCells found;
  found.body_cell.resize(bodies.size());
  if (cells.size() <= 4LL * bodies.size()) {  // a table of all cells is faster than sorting
    std::vector<int> number(cells.size(), -1);
    for (const std::int64_t c : cell) number[c] = 0;
    for (std::int64_t c = 0; c < cells.size(); ++c)
      if (number[c] == 0) number[c] = found.size(), found.cell.push_back(c);
    for (int i = 0; i < bodies.size(); ++i) found.body_cell[i] = number[cell[i]];
    return found;
  }
  found.cell = cell;
  std::ranges::sort(found.cell);
  found.cell.erase(std::ranges::unique(found.cell).begin(), found.cell.end());
  for (int i = 0; i < bodies.size(); ++i) found.body_cell[i] = found.find(cell[i]);
  return found;
}

}  // namespace lichtenberg::analysis
