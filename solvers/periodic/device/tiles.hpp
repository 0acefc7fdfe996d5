#pragma once

// Tiles of the box for spreading and interpolating charges.

#include <algorithm>
#include <cmath>

#include "solvers/neighbours/table.hpp"
#include "solvers/periodic/device/tables.hpp"

namespace lichtenberg::periodic::device {

/// Returns the number of tiles of about `wanted` mesh points along an axis with this number of points.
inline int tiles_along(int points, int wanted) {
  return std::max(1, static_cast<int>(std::lround(static_cast<double>(points) / wanted)));
}

/// Chooses the edges of cells for neighbour lists with the cut-off plus `more` (length): about a half along x and y, a
/// quarter along z. The number of cells along an axis is a multiple of the number of tiles with 16 points, if possible.
inline Vec3 cell_edges(const MeshTables& tables, double more) {
  const double range = tables.cutoff + more;
  Vec3 edge{range / 2, range / 2, range / 4};
  for (int k = 0; k < 3; ++k) {
    const double length = tables.mesh.lengths[k];
    const int tiles = tiles_along(tables.mesh.points[k], 16), in_tile = static_cast<int>(length / edge[k] / tiles);
    if (in_tile > 0) edge[k] = length / (tiles * in_tile) * (1 - 1e-9);
  }
  return edge;
}

/// Division of the periodic box into tiles. A tile is a block of cells whose charges one block of threads processes.
/// Its region consists of all mesh points within reach of these charges. Tiles remain valid if charges have moved by
/// some mesh points since they were sorted by cells.
struct Tiles {
  CellsView cells;
  int points[3], group[3], tiles[3];  ///< Mesh points, cells per tile and tiles along an axis
  int size[3];                        ///< Points of a region along an axis
  int moved[3];                       ///< Number of points that the charges may have moved
  /// Index of the first charge of each run of a tile [tiles * runs + 1]; charges of all tiles, tile by tile [N].
  const int *first, *charge;
  float over_plane, over_row;  ///< Slightly above 1 / points of a region's plane and row

  /// Returns the number of tiles.
  int count() const { return tiles[0] * tiles[1] * tiles[2]; }
  /// Returns the number of mesh points of a region.
  LICHTENBERG_HOST_DEVICE int region() const { return size[0] * size[1] * size[2]; }
  /// Returns the number of runs of a tile: columns of cells along z, whose charges are consecutive.
  LICHTENBERG_HOST_DEVICE int runs() const { return group[0] * group[1]; }
  /// Returns the index in `charge` of the first charge of a tile.
  LICHTENBERG_HOST_DEVICE int begin(int tile) const { return first[tile * runs()]; }

  /// Returns the index along an axis of the first cell of a tile.
  LICHTENBERG_HOST_DEVICE int cell(int tile, int axis) const {
    const int at = axis == 0 ? tile / (tiles[1] * tiles[2]) : axis == 1 ? tile / tiles[2] % tiles[1] : tile % tiles[2];
    return at * group[axis];
  }
  /// Returns the index along an axis of the first mesh point of a tile's region; may be negative.
  LICHTENBERG_HOST_DEVICE int low(int tile, int axis) const {
    return static_cast<int>(static_cast<long>(cell(tile, axis)) * points[axis] / cells.cells[axis]) - moved[axis];
  }
  /// Returns the index along an axis, within a region that begins at `from`, of a mesh point of the box.
  LICHTENBERG_HOST_DEVICE int local(int point, int from, int axis) const {
    const int d = point - from;
    return d < 0 ? d + points[axis] : d >= points[axis] ? d - points[axis] : d;
  }
  /// Returns an index within a region, with periodic wrap for a region as long as the box.
  LICHTENBERG_HOST_DEVICE int wrapped(int local, int axis) const {
    return local >= points[axis] ? local - points[axis] : local;
  }
  /// Returns the index on the mesh of the k-th point of a region that begins at the point `from`.
  LICHTENBERG_HOST_DEVICE int global(const int* from, int k) const {
    // Divides integers of 20 bits without an integer division.
    const int plane = static_cast<int>(static_cast<float>(k) * over_plane), in_plane = k - plane * size[1] * size[2];
    const int row = static_cast<int>(static_cast<float>(in_plane) * over_row);
    const int x = wrapped_global(from[0] + plane, 0), y = wrapped_global(from[1] + row, 1),
              z = wrapped_global(from[2] + in_plane - row * size[2], 2);
    return (x * points[1] + y) * points[2] + z;
  }

  /// Computes the range begin ... end - 1 of sorted charges in run r (a column of cells along z) of a tile, of those
  /// from `least` to `most` - 1.
  LICHTENBERG_HOST_DEVICE void run(int tile, int r, int least, int most, int& begin, int& end) const {
    const int x = cell(tile, 0) + r / group[1], y = cell(tile, 1) + r % group[1], z = cell(tile, 2);
    begin = end = 0;
    if (x >= cells.cells[0] || y >= cells.cells[1]) return;
    const int last = z + group[2] < cells.cells[2] ? z + group[2] : cells.cells[2];
    begin = cells.first[cells.number(x, y, z)];
    end = cells.first[cells.number(x, y, 0) + last];
    begin = begin < least ? least : begin > most ? most : begin, end = end < least ? least : end > most ? most : end;
  }

 private:
  LICHTENBERG_HOST_DEVICE int wrapped_global(int point, int axis) const {
    return point < 0 ? point + points[axis] : point >= points[axis] ? point - points[axis] : point;
  }
};

}  // namespace lichtenberg::periodic::device
