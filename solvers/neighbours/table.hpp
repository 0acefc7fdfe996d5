#pragma once

// Neighbour lists in a periodic box on an executor (solvers/parallel): particles sorted by cells, and a list of
// partners for each.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/geometry/host_device.hpp"
#include "solvers/geometry/vec.hpp"
#include "solvers/neighbours/ring_range.hpp"
#include "solvers/parallel/array.hpp"
#include "solvers/parallel/host_executor.hpp"

namespace lichtenberg {

/// Fixed-point position in a periodic box: each coordinate is a fraction of the box length in units of 2^-32. Integer
/// differences wrap like the box: the signed difference of two coordinates is that of the nearest images. The upper 32
/// bits of the product with a number of cells are the index of the cell.
struct FixedPointPosition {
  std::uint32_t x = 0, y = 0, z = 0;
};

/// Number of fixed-point units in a box length.
constexpr double units_per_box = 0x1p32;

/// Converts a coordinate (m), in any periodic image of the box, to fixed point. `units_per_length`: 2^32 / box length
/// (1/m).
LICHTENBERG_HOST_DEVICE inline std::uint32_t fixed_point_coordinate(double position, double units_per_length) {
  return static_cast<std::uint32_t>(static_cast<long long>(std::floor(position * units_per_length)));
}
/// Returns the minimum-image difference a - b of two fixed-point coordinates, in units of 2^-32 of the box length.
LICHTENBERG_HOST_DEVICE inline float nearest_difference(std::uint32_t a, std::uint32_t b) {
  return static_cast<float>(static_cast<std::int32_t>(a - b));
}
/// Returns the index of the cell that contains a fixed-point coordinate, for `cells` equal cells along the axis.
LICHTENBERG_HOST_DEVICE inline int cell_of(std::uint32_t coordinate, int cells) {
  return static_cast<int>((static_cast<std::uint64_t>(coordinate) * static_cast<std::uint64_t>(cells)) >> 32);
}

/// View of a CellGrid for kernels: numbers of cells along the axes, and the range of sorted particles in each cell.
/// Cell (x, y, z) has the number (x * cells[1] + y) * cells[2] + z.
struct CellsView {
  std::array<int, 3> cells{};
  const int* first = nullptr;  ///< Index of the first particle of each cell in the sorted order; [cells + 1]

  LICHTENBERG_HOST_DEVICE int number(int x, int y, int z) const { return (x * cells[1] + y) * cells[2] + z; }
};

/// Cell list in a periodic box on an executor: sorts particles by the cells that contain them.
template <class Executor>
class CellGrid {
 public:
  /// Divides a box with the given edge lengths (m) into equal cells with edges of at least `edge` (m), at most 1024 per
  /// axis. An axis shorter than `edge` has one cell.
  CellGrid(const Executor& run, Vec3 lengths, Vec3 edge)
      : run_(&run), cell_(run), index_in_cell_(run), order_(run), first_(run) {
    for (int k = 0; k < 3; ++k) cells_[k] = std::clamp(static_cast<int>(lengths[k] / edge[k]), 1, 1024);
  }

  /// Sorts n particles by cells; `position_of(i)` returns the position of particle i as `FixedPointPosition`. order()
  /// then lists the particles cell by cell, in arbitrary order within a cell.
  template <class PositionOf>
  void sort(int n, PositionOf position_of) {
    cell_.resize(n);
    index_in_cell_.resize(n);
    order_.resize(n);
    const CellsView cells{cells_};
    const int all = cells_[0] * cells_[1] * cells_[2];
    first_.resize(all + 1);
    first_.zero();
    int *cell = cell_.data(), *index_in_cell = index_in_cell_.data(), *first = first_.data(), *order = order_.data();
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int i) {
      const FixedPointPosition at = position_of(i);
      cell[i] =
          cells.number(cell_of(at.x, cells.cells[0]), cell_of(at.y, cells.cells[1]), cell_of(at.z, cells.cells[2]));
      index_in_cell[i] = parallel::take_index(&first[cell[i]]);
    });
    run_->exclusive_scan(first, all + 1);
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int i) { order[first[cell[i]] + index_in_cell[i]] = i; });
  }
  const int* order() const { return order_.data(); }  ///< Particles by cells, in device memory
  /// Returns the index of the first particle of each layer of cells along x in the sorted order, then the number of
  /// particles.
  std::vector<int> layer_starts() const {
    parallel::Array<int, Executor> starts(*run_);
    starts.resize(cells_[0] + 1);
    const int *first = first_.data(), a_layer = cells_[1] * cells_[2];
    int* to = starts.data();
    run_->for_each(cells_[0] + 1, [=] LICHTENBERG_HOST_DEVICE(int x) { to[x] = first[x * a_layer]; });
    return starts.download();
  }
  /// Replaces the order of the particles within the cells by that of rank 0.
  void share_order() { run_->broadcast(order_.data(), static_cast<long>(order_.size())); }
  CellsView view() const { return {cells_, first_.data()}; }  ///< View for kernels, valid until the next sort

 private:
  const Executor* run_;
  std::array<int, 3> cells_{};
  parallel::Array<int, Executor> cell_, index_in_cell_, order_, first_;
};

/// Search window of a cell list: cells around a position that contain all particles within a range of it. The window
/// consists of columns of cells along z; the particles of a column are contiguous in the sorted order, except across
/// the periodic boundary.
struct CellWindow {
  CellsView grid;
  std::array<int, 3> reach{}, width{};  ///< Numbers of cells along each axis: to either side, and in total
  std::array<float, 3> edge{};          ///< Edges of a cell (m)
  float range2;                         ///< Squared range (m^2), slightly enlarged for rounding

  CellWindow(CellsView cells, Vec3 lengths, double range)
      : grid(cells), range2(static_cast<float>(range * range * (1 + 1e-5))) {
    for (int k = 0; k < 3; ++k) {
      edge[k] = static_cast<float>(lengths[k] / cells.cells[k]);
      reach[k] = static_cast<int>(std::ceil(range * cells.cells[k] / lengths[k]));
      width[k] = std::min(2 * reach[k] + 1, cells.cells[k]);
    }
  }
  /// Returns the number of columns of the window.
  LICHTENBERG_HOST_DEVICE int columns() const { return width[0] * width[1]; }

  /// Calls visit(j) for the particles j in column c of the window around position `at`, at least in the cells that
  /// intersect the range. j is the index in the sorted order.
  template <class Visit>
  LICHTENBERG_HOST_DEVICE void visit(FixedPointPosition at, int c, Visit visit) const {
    const int x = wrapped(at.x, 0, c / width[1]), y = wrapped(at.y, 1, c % width[1]);
    const int column = grid.number(x, y, 0), cells = grid.cells[2];
    int from = 0, end = cells;
    const float gap_x = gap(at.x, 0, c / width[1]), gap_y = gap(at.y, 1, c % width[1]);
    const float left = range2 - gap_x * gap_x - gap_y * gap_y;
    if (left < 0) return;
    if (width[2] < cells) {
      const float half = std::sqrt(left) / edge[2] + 1e-3f, offset = offset_in_cell(at.z, 2);
      const int cell = cell_of(at.z, cells), low = static_cast<int>(std::floor(offset - half)),
                high = static_cast<int>(std::floor(offset + half));
      from = cell + (low > -reach[2] ? low : -reach[2]), end = cell + (high < reach[2] ? high : reach[2]) + 1;
    }
    run(column, from < 0 ? 0 : from, end > cells ? cells : end, visit);
    if (from < 0) run(column, from + cells, cells, visit);
    if (end > cells) run(column, 0, end - cells, visit);
  }

 private:
  /// Returns the offset of a coordinate from the lower face of its cell, as a fraction of the cell.
  LICHTENBERG_HOST_DEVICE float offset_in_cell(std::uint32_t coordinate, int axis) const {
    return static_cast<float>(static_cast<std::uint32_t>(coordinate * static_cast<std::uint32_t>(grid.cells[axis]))) *
           0x1p-32f;
  }
  /// Returns the distance (m) along an axis from `coordinate` to the cells at position `step` (0 ... width - 1) of the
  /// search window, slightly reduced for rounding.
  LICHTENBERG_HOST_DEVICE float gap(std::uint32_t coordinate, int axis, int step) const {
    if (width[axis] == grid.cells[axis]) return 0;
    const auto off = static_cast<float>(step - reach[axis]);
    const float offset = offset_in_cell(coordinate, axis), cells = off < 0   ? offset - off - 1
                                                                   : off > 0 ? off - offset
                                                                             : 0;
    return cells > 1e-4f ? (cells - 1e-4f) * edge[axis] : 0;
  }
  /// Returns the cell index along an axis at position `step` (0 ... width - 1) of the search window around
  /// `coordinate`, with periodic wrap.
  LICHTENBERG_HOST_DEVICE int wrapped(std::uint32_t coordinate, int axis, int step) const {
    const int cells = grid.cells[axis];
    if (width[axis] == cells) return step;
    const int cell = cell_of(coordinate, cells) - reach[axis] + step;
    return cell < 0 ? cell + cells : cell >= cells ? cell - cells : cell;
  }
  template <class Visit>
  LICHTENBERG_HOST_DEVICE void run(int column, int from, int end, Visit& visit) const {
    const int last = grid.first[column + end];
    for (int j = grid.first[column + from]; j < last; ++j) visit(j);
  }
};

/// Distance criterion of a neighbour list: returns true if the nearest images of two positions are within a range.
/// Explicit fused multiply-adds make the rounding identical in the counting and the listing of pairs, and for both
/// particles of a pair.
struct RangeTest {
  float x, y, z;  ///< Lengths of the box over 2^32 (m)
  float most;     ///< Squared range (m^2)

  LICHTENBERG_HOST_DEVICE bool operator()(FixedPointPosition a, FixedPointPosition b) const {
    const float dx = x * nearest_difference(a.x, b.x), dy = y * nearest_difference(a.y, b.y),
                dz = z * nearest_difference(a.z, b.z);
    return std::fma(dx, dx, std::fma(dy, dy, dz * dz)) < most;
  }
};

/// Search of a NeighbourTable: finds the partners of each particle, which form a row of the table. A row is divided
/// into parts, one thread each, that search different columns of cells.
template <class PositionOf>
struct RowParts {
  CellWindow window;
  RangeTest within;
  PositionOf position_of;
  int n, parts;    ///< Number of particles; parts per row
  bool once;       ///< True if each pair is only in the row of the particle that comes first
  RingRange rows;  ///< Particles whose rows are built; the others are empty

  /// Calls visit(j) for the partners j in part k / n of row k % n (k: thread, n: number of particles). Neighbouring
  /// threads thus process particles that are neighbours in the sorted order.
  template <class Visit>
  LICHTENBERG_HOST_DEVICE void operator()(int k, Visit visit) const {
    const int s = k % n, all = window.columns(), a_part = (all + parts - 1) / parts, first = k / n * a_part;
    if (!rows.contains(s)) return;
    const int end = first + a_part < all ? first + a_part : all;
    const FixedPointPosition at = position_of(s);
    for (int c = first; c < end; ++c)
      window.visit(at, c, [&](int j) {
        if ((once ? j > s : j != s) && within(at, position_of(j))) visit(j);
      });
  }
};

/// View of a NeighbourTable for kernels: the partners of particle s are the entries begin(s) ... end(s) - 1 of
/// `partner`.
struct TableView {
  const int *start = nullptr, *partner = nullptr;
  int columns = 1;  ///< Parts per row: entries of `start` per particle

  LICHTENBERG_HOST_DEVICE int begin(int s) const { return start[static_cast<long>(s) * columns]; }
  LICHTENBERG_HOST_DEVICE int end(int s) const { return start[static_cast<long>(s + 1) * columns]; }
};

/// Neighbour list on an executor, in a periodic box: for each particle a row of its partners within a range.
/// Construction counts the partners first, so rows need no maximum length.
template <class Executor>
class NeighbourTable {
 public:
  explicit NeighbourTable(const Executor& run) : run_(&run), start_(run), partner_(run) {}

  /// Builds the table of n particles that are sorted by `cells`; `position_of(s)` returns the position of the s-th as
  /// `FixedPointPosition`. `lengths`: edges of the box (m). `range` (m) is at most half of an edge; rounding can add
  /// pairs slightly beyond it. Each pair is in the rows of both particles, or with `once` only in the row of the
  /// particle that comes first in the sorted order. Only the rows of the particles `rows` are built; the others are
  /// empty.
  template <class PositionOf>
  void build(const RingRange& rows, const CellsView& cells, Vec3 lengths, double range, PositionOf position_of,
             bool once = false) {
    const int n = rows.size;
    const CellWindow window(cells, lengths, range);
    const int columns = window.columns(), threads = cut(n, columns);
    start_.resize(static_cast<std::size_t>(n) * columns_ + 1);
    const RangeTest within{static_cast<float>(lengths.x / units_per_box), static_cast<float>(lengths.y / units_per_box),
                           static_cast<float>(lengths.z / units_per_box),
                           static_cast<float>(range * range * (1 + 1e-6))};
    const int parts = columns_;
    const RowParts<PositionOf> visit{window, within, position_of, n, parts, once, rows};
    int* start = start_.data();
    run_->template for_each<128>(threads + 1L, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int count = 0;
      if (k < threads) visit(k, [&](int) { ++count; });
      start[k < threads ? k % n * parts + k / n : threads] = count;
    });
    run_->exclusive_scan(start, static_cast<long>(threads) + 1);
    int total = 0;
    run_->to_host(&total, start + threads, sizeof(int));
    partner_.resize(total);
    int* partner = partner_.data();
    run_->template for_each<128>(threads, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int* to = partner + start[k % n * parts + k / n];
      visit(k, [&](int j) { *to++ = j; });
    });
  }
  /// Builds all rows of the table of n particles.
  template <class PositionOf>
  void build(int n, const CellsView& cells, Vec3 lengths, double range, PositionOf position_of, bool once = false) {
    build(RingRange::whole(n), cells, lengths, range, position_of, once);
  }
  TableView view() const { return {start_.data(), partner_.data(), columns_}; }  ///< Valid until the next build

  /// Returns the number of partners in all rows together.
  std::size_t entries() const { return partner_.size(); }

 private:
  /// Chooses the number of parts per row (one thread each): the fewest parts that occupy a device, at most one per
  /// column of the search window. Returns the number of threads.
  int cut(int n, int columns) {
    constexpr int enough = 1 << 18;
    columns_ = std::clamp((enough + n - 1) / std::max(n, 1), 1, columns);
    return n * columns_;
  }

  const Executor* run_;
  int columns_ = 1;
  parallel::Array<int, Executor> start_, partner_;
};

}  // namespace lichtenberg
