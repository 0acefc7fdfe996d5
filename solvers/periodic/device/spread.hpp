#pragma once

// Spreading of charges on a mesh of integers, so that sums are bitwise identical in any order.

#include "solvers/periodic/device/near.hpp"
#include "solvers/periodic/device/tiles.hpp"
#include "solvers/periodic/device/window.hpp"

namespace lichtenberg::periodic::device {

/// Kernel that spreads sources on the mesh (charge assignment): adds charges, dipoles or both to a mesh of integers, on
/// which a unit charge is `unit`. A block handles a tile (part of the box). The potential of a dipole is mu.grad of
/// that of a charge, with respect to the source's position. A dipole is therefore spread with mu.grad of the weights.
/// `Whole`: type of the integers.
template <int order, Kind kind = Kind::charges, class Whole = int>
struct Spread {
  static constexpr int batch = 256;  ///< Number of charges whose weights are stored at a time
  Tiles tiles;
  Weigher<order> window;
  const PointCharge* charges;
  Whole* mesh;
  float unit;
  const Moment* moments = nullptr;
  float inverse_spacing[3] = {};

  static constexpr bool dipoles = kind != Kind::charges;
  /// Returns the fast memory of a block (bytes).
  static std::size_t bytes(const Tiles& tiles) { return sizeof(Whole) * tiles.region() + batch * sizeof(Weights); }
  /// Weights of a charge's points along the axes, and the charge's first point.
  struct Weights {
    float weight[3][order];
    float slope[dipoles ? 3 : 1][dipoles ? order : 1];  ///< Slopes times the dipole
    int at[3];
    float charge;
  };

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int tile) const {
    Weights* weights = block.template memory<Weights>();
    Whole* local = reinterpret_cast<Whole*>(weights + batch);
    const int from[3] = {tiles.low(tile, 0), tiles.low(tile, 1), tiles.low(tile, 2)};
    block.template each<8>(tiles.region(), [&](int k) { local[k] = 0; });
    const int end = tiles.begin(tile + 1);
    for (int first = tiles.begin(tile); first < end; first += batch) {
      const int now = end - first < batch ? end - first : batch;
      block.each(3 * now, [&](int k) { weigh(weights[k / 3], k % 3, tiles.charge[first + k / 3], from); });
      block.each(now * order, [&](int k) { spread(weights[k / order], k % order, local); });
    }
    block.template each<8>(tiles.region(), [&](int k) {
      if (local[k] != 0) parallel::add_atomically(&mesh[tiles.global(from, k)], local[k]);
    });
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, int s, const int* from) const {
    const PointCharge of = charges[s];
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    float weight[order];
    if constexpr (dipoles) {
      float slope[order];
      window.weights(at.from_middle, weight, slope);
      const Moment m = moments[s];
      const float factor = inverse_spacing[axis] * (axis == 0 ? m.x : axis == 1 ? m.y : m.z);
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) to.weight[axis][c] = weight[c], to.slope[axis][c] = factor * slope[c];
      if (axis == 0) to.charge = kind == Kind::multipoles ? of.charge : 0;
    } else {
      window.weights(at.from_middle, weight);
      const float factor = axis == 0 ? unit * of.charge : 1;
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) to.weight[axis][c] = factor * weight[c];
    }
    to.at[axis] = tiles.local(at.point, from[axis], axis);
  }
  /// Spreads a source on the a-th plane of its points.
  LICHTENBERG_HOST_DEVICE void spread(const Weights& of, int a, Whole* local) const {
    const int plane = tiles.wrapped(of.at[0] + a, 0) * tiles.size[1];
    float y[order], z[order];  // Copies: without them the compiler must assume that writes to `local` alias the weights
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) y[c] = of.weight[0][a] * of.weight[1][c], z[c] = of.weight[2][c];
    float moved[dipoles ? order : 1], also[dipoles ? order : 1];
    if constexpr (dipoles) {
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) {
        moved[c] = of.slope[0][a] * of.weight[1][c] + of.weight[0][a] * of.slope[1][c];
        also[c] = unit * z[c];
        z[c] = unit * (of.charge * z[c] + of.slope[2][c]);
      }
    }
    const int j = of.at[1], l = of.at[2];
    const bool wraps = l + order > tiles.points[2];
    LICHTENBERG_UNROLL(8)
    for (int b = 0; b < order; ++b) {
      Whole* row = local + (plane + tiles.wrapped(j + b, 1)) * tiles.size[2];
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c)
        parallel::add_atomically(
            &row[wraps ? tiles.wrapped(l + c, 2) : l + c],
            rounded_to_integer<Whole>(dipoles ? y[b] * z[c] + moved[dipoles ? b : 0] * also[dipoles ? c : 0]
                                              : y[b] * z[c]));
    }
  }
};

}  // namespace lichtenberg::periodic::device
