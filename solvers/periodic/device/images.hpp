#pragma once

// Image charges in grounded sides, on an executor.

#include <vector>

#include "solvers/periodic/device/near.hpp"
#include "solvers/periodic/device/tiles.hpp"
#include "solvers/periodic/device/totals.hpp"

namespace lichtenberg::periodic::device {

/// Returns image `copy` (0: the charge itself) of a position in grounded sides.
LICHTENBERG_HOST_DEVICE inline FixedPointPosition mirrored(const Mirrors& mirrors, FixedPointPosition at, int copy) {
  int axis_bit = 1;
  std::uint32_t* const coordinate[3] = {&at.x, &at.y, &at.z};
  for (int k = 0; k < 3; ++k) {
    if (!mirrors.along[k]) continue;
    if (copy & axis_bit) *coordinate[k] = mirrors.twice[k] - *coordinate[k];
    axis_bit *= 2;
  }
  return at;
}
/// Returns the charge of image `copy` of a unit charge: -1 for an odd number of reflections.
LICHTENBERG_HOST_DEVICE inline float mirrored_sign(int copy) {
  return (copy & 1) ^ (copy >> 1 & 1) ^ (copy >> 2 & 1) ? -1.0f : 1.0f;
}

/// Charges in a box with grounded sides, together with their image charges (BoundedSum), sorted by cells of their own.
/// Sums over all of them give the results of the charges.
template <class Executor>
class ImageCharges {
 public:
  ImageCharges(const Executor& run, const MeshTables& tables)
      : run_(&run),
        mirrors_(tables.mirrors),
        lengths_(tables.mesh.lengths),
        cells_(run, tables.mesh.lengths, cell_edges(tables, 0.6)),
        table_(run),
        position_(run),
        charges_(run),
        field_(run) {}

  int size() const { return copies() * n_; }  ///< Number of charges with all images
  int copies() const { return mirrors_.copies(); }
  CellsView cells() const { return cells_.view(); }
  TableView partners() const { return table_.view(); }
  const PointCharge* charges() const { return charges_.data(); }  ///< All charges, sorted, after fill()
  FieldSample* field() const { return field_.data(); }            ///< Fields at all charges, to be computed

  /// Sorts n charges with their images, and makes the lists of partners up to the distance `range`. at(s) returns the
  /// position of charge s.
  template <class At>
  void arrange(int n, double range, At at) {
    n_ = n;
    position_.resize(size()), charges_.resize(size()), field_.resize(size());
    field_.zero();
    FixedPointPosition* position = position_.data();
    const Mirrors mirrors = mirrors_;
    run_->for_each(size(), [=] LICHTENBERG_HOST_DEVICE(int k) { position[k] = mirrored(mirrors, at(k % n), k / n); });
    cells_.sort(size(), [=] LICHTENBERG_HOST_DEVICE(int k) { return position[k]; });
    const int* order = cells_.order();
    table_.build(size(), cells_.view(), lengths_, range,
                 [=] LICHTENBERG_HOST_DEVICE(int k) { return position[order[k]]; });
  }
  /// Sets the positions and charges of all images from those of the charges.
  void fill(const PointCharge* from) {
    PointCharge* to = charges_.data();
    const int *order = cells_.order(), n = n_;
    const Mirrors mirrors = mirrors_;
    run_->for_each(size(), [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int copy = order[k] / n;
      const PointCharge one = from[order[k] % n];
      to[k] = {mirrored(mirrors, one.at, copy), mirrored_sign(copy) * one.charge};
    });
  }
  /// Copies the fields at the charges themselves to `to`, and divides the energy of all by the number of copies, which
  /// is the energy of the field in the box.
  void take(FieldSample* to, Totals* totals) const {
    const FieldSample* field = field_.data();
    const int *order = cells_.order(), n = n_, all = copies();
    run_->for_each(size(), [=] LICHTENBERG_HOST_DEVICE(int k) {
      if (order[k] < n) to[order[k]] = field[k];
      if (k == 0) totals->energy /= all;
    });
  }

 private:
  const Executor* run_;
  Mirrors mirrors_;
  Vec3 lengths_;
  int n_ = 0;
  CellGrid<Executor> cells_;
  NeighbourTable<Executor> table_;
  parallel::Array<FixedPointPosition, Executor> position_;
  parallel::Array<PointCharge, Executor> charges_;
  parallel::Array<FieldSample, Executor> field_;
};

}  // namespace lichtenberg::periodic::device
