#pragma once

// Mesh part of the sums on an executor: spreads charges by tiles of the box in fast memory, transforms, and
// interpolates by the same tiles.

#include <cmath>

#include "solvers/periodic/device/fft.hpp"
#include "solvers/periodic/device/gather.hpp"
#include "solvers/periodic/device/spread.hpp"

namespace lichtenberg::periodic::device {

/// Mesh part of a periodic Coulomb sum on an executor: spreads charges on the mesh, computes the potential by FFT, and
/// interpolates. The order of calls is arrange(), spread(), solve(), gather().
template <class Executor>
class MeshPart {
 public:
  /// Prepares the mesh with the given tables; `run` must outlive this object.
  MeshPart(const Executor& run, const MeshTables& tables)
      : run_(&run),
        tables_(tables),
        fft_(run, tables.mesh.points),
        factor_(run),
        whole_(run),
        wide_(run),
        real_(run),
        modes_(run),
        first_(run),
        charge_(run) {
    factor_.upload(tables.factor);
    const auto [x, y, z] = tables.mesh.points;
    points_ = static_cast<long>(x) * y * z;
    is_wide_ = tables.mesh.open.any();
    whole_.resize(is_wide_ ? 0 : points_);
    wide_.resize(is_wide_ ? points_ : 0);
    real_.resize(points_);
    modes_.resize(2 * tables.factor.size());
    is_wide_ ? wide_.zero() : whole_.zero();
    // Scale of the integer mesh. It bounds the charge of a point by that of touching grains, at most 1.5 of charge 1 in
    // unit volume, with a margin that includes their dipoles. Rounding errors are 1e-8 of this bound.
    const Vec3 h = tables.mesh.spacing();
    unit_ = static_cast<float>(std::exp2(30 - std::ceil(std::log2(8 + 6 * h.x * h.y * h.z))));
    // The mesh of a dilute cloud is coarse, so that this bound is far above the charge of a point. Integers of 64 bits
    // hold 2^23 charges in a point.
    if (is_wide_) unit_ = 0x1p40f;
  }

  /// Divides the box into tiles for n charges that are sorted by `cells` and move by at most `moved` (length) before
  /// the next sorting. `own`: charges that this rank spreads and at which it interpolates.
  void arrange(const RingRange& own, const CellsView& cells, double moved) {
    const int n = own.count, from = own.first, to = own.first + own.count;
    // Larger tiles have fewer shared points around them, but there must be enough tiles to occupy the whole device,
    // with two blocks per processor.
    constexpr int enough = 120, most_points = 16000;
    for (const std::array<int, 3>& points :
         {std::array{16, 16, 32}, {16, 16, 16}, {16, 16, 8}, {8, 16, 8}, {8, 8, 8}}) {
      cut(cells, moved, points);
      if (tiles_.count() >= enough && tiles_.region() <= most_points) break;
    }
    // Slightly above 1 / size, so that products with integers up to 2^22 are rounded down to the exact quotient.
    const auto above = [](int size) { return std::nextafter(1.0f / static_cast<float>(size), 1.0f); };
    tiles_.over_plane = above(tiles_.size[1] * tiles_.size[2]);
    tiles_.over_row = above(tiles_.size[2]);
    const Tiles tiles = tiles_;
    const int runs = tiles.runs(), all = tiles.count() * runs;
    first_.resize(all + 1);
    charge_.resize(n);
    constexpr int many = 1 << 14;
    energy_grid_ = is_wide_ && own.size > many ? grid_of_large_energies : fine_grid;
    int *first = first_.data(), *charge = charge_.data();
    run_->for_each(all + 1, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int begin = 0, end = 0;
      if (k < all) tiles.run(k / runs, k % runs, from, to, begin, end);
      first[k] = end - begin;
    });
    run_->exclusive_scan(first, all + 1);
    run_->for_each(all, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int begin = 0, end = 0;
      tiles.run(k / runs, k % runs, from, to, begin, end);
      for (int s = begin; s < end; ++s) charge[first[k] + s - begin] = s;
    });
    tiles_.first = first;
    tiles_.charge = charge;
  }

  /// Divides the box into tiles of about `wanted` mesh points along each axis.
  void cut(const CellsView& cells, double moved, const std::array<int, 3>& wanted) {
    const Vec3 spacing = tables_.mesh.spacing();
    tiles_.cells = cells;
    for (int k = 0; k < 3; ++k) {
      const int points = tables_.mesh.points[k], all = cells.cells[k];
      const double a_cell = static_cast<double>(points) / all;
      tiles_.points[k] = points;
      const int tiles = std::min(tiles_along(points, wanted[k]), all);
      tiles_.group[k] = (all + tiles - 1) / tiles;
      tiles_.tiles[k] = (all + tiles_.group[k] - 1) / tiles_.group[k];
      tiles_.moved[k] = static_cast<int>(std::ceil(moved / spacing[k]));
      tiles_.size[k] = std::min(
          static_cast<int>(std::ceil(tiles_.group[k] * a_cell)) + 1 + 2 * tiles_.moved[k] + tables_.mesh.order, points);
    }
  }

  // Call order: spread, solve, gather.

  /// Spreads charges, dipoles (`moments`) alone, or both on the mesh, as selected by `kind`.
  template <Kind kind>
  void spread(const PointCharge* charges, const Moment* moments = nullptr) {
    is_wide_ ? spread_on<kind>(charges, moments, wide_.data()) : spread_on<kind>(charges, moments, whole_.data());
  }
  /// Spreads sources on a mesh of integers.
  template <Kind kind, class Whole>
  void spread_on(const PointCharge* charges, const Moment* moments, Whole* whole) {
    with_window([&]<int order>(const Weigher<order>& window) {
      Spread<order, kind, Whole> spread{tiles_, window, charges, whole, unit_, moments, {}};
      for (int k = 0; k < 3; ++k) spread.inverse_spacing[k] = tables_.inverse_spacing[k];
      run_->template for_each_block<512>(tiles_.count(), Spread<order, kind, Whole>::bytes(tiles_), spread);
    });
  }
  /// Computes the potential on the mesh from the charges that all ranks have spread: FFT, influence function, inverse
  /// FFT.
  void solve() {
    is_wide_ ? run_->sum_over_ranks(wide_.data(), points_) : run_->sum_over_ranks(whole_.data(), points_);
    is_wide_ ? take(wide_.data()) : take(whole_.data());
    float *real = real_.data(), *modes = modes_.data();
    const float* factor = factor_.data();
    fft_.forward(real, modes);
    run_->for_each(static_cast<long>(factor_.size()), [=] LICHTENBERG_HOST_DEVICE(int k) {
      modes[2 * k] *= factor[k];
      modes[2 * k + 1] *= factor[k];
    });
    fft_.backward(modes, real);
  }
  /// Converts the mesh of integers to real numbers, and clears it.
  template <class Whole>
  void take(Whole* whole) {
    float* real = real_.data();
    const float over_unit = 1 / unit_;
    run_->for_each(points_, [=] LICHTENBERG_HOST_DEVICE(int k) {
      real[k] = over_unit * static_cast<float>(whole[k]);
      whole[k] = 0;
    });
  }
  /// Arrays of gather(): sources, and the fields and forces to which it adds; `moments` and `force` only with dipoles.
  struct Gathered {
    const PointCharge* charges;
    const Moment* moments;
    FieldSample *field_at_source, *force;
  };
  /// Interpolates the potential at the sources: adds to fields, potentials and forces, and to `totals` unless it is
  /// null. The potential of the neutralizing background is not included.
  template <Kind kind>
  void gather(const Gathered& to, Totals* totals) {
    const auto inverse_separation2 = static_cast<float>(1 / (tables_.reach * tables_.reach));
    with_window([&]<int order>(const Weigher<order>& window) {
      Gather<order, kind> gather{
          tiles_, window,     to.charges, real_.data(),       to.field_at_source,  totals,      {}, tables_.self,
          {},     to.moments, to.force,   tables_.self_field, inverse_separation2, energy_grid_};
      for (int k = 0; k < 3; ++k) {
        gather.inverse_spacing[k] = tables_.inverse_spacing[k];
        gather.wave[0][k] = tables_.wave[0][k], gather.wave[1][k] = tables_.wave[1][k];
      }
      run_->template for_each_block<512>(tiles_.count(), Gather<order, kind>::bytes(tiles_), gather);
    });
  }

 private:
  /// Calls work(Weigher) for the mesh's order.
  template <class Work>
  void with_window(Work&& work) const {
    switch (tables_.mesh.order) {
      case 4:
        return work(window<4>());
      case 5:
        return work(window<5>());
      case 6:
        return work(window<6>());
      default:
        return work(window<7>());
    }
  }
  template <int order>
  Weigher<order> window() const {
    Weigher<order> window;
    for (int d = 0; d < order; ++d)
      for (int c = 0; c < order; ++c) window.term[d][c] = tables_.window[d * order + c];
    return window;
  }

  const Executor* run_;
  MeshTables tables_;
  Fft<Executor> fft_;
  parallel::Array<float, Executor> factor_;
  parallel::Array<int, Executor> whole_;          ///< Integer mesh
  parallel::Array<std::int64_t, Executor> wide_;  ///< Integer mesh with 64 bits, if is_wide_
  bool is_wide_ = false;
  parallel::Array<float, Executor> real_, modes_;
  parallel::Array<int, Executor> first_, charge_;  ///< Charges of the tiles: index of the first, and list
  long points_ = 0;
  float unit_ = 1;
  double energy_grid_ = fine_grid;  ///< Quantum of energies in totals
  Tiles tiles_{};
};

}  // namespace lichtenberg::periodic::device
