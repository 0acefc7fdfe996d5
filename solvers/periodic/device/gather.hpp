#pragma once

// Interpolation of fields and forces on charges from the potential on a mesh.

#include <type_traits>

#include "solvers/periodic/device/near.hpp"
#include "solvers/periodic/device/tiles.hpp"
#include "solvers/periodic/device/totals.hpp"
#include "solvers/periodic/device/window.hpp"
#include "solvers/periodic/self_term.hpp"

namespace lichtenberg::periodic::device {

/// Second derivatives of a potential, per squared mesh spacing.
struct Curvature {
  float xx = 0, yy = 0, zz = 0, yz = 0, zx = 0, xy = 0;

  LICHTENBERG_HOST_DEVICE void operator+=(const Curvature& o) {
    xx += o.xx, yy += o.yy, zz += o.zz, yz += o.yz, zx += o.zx, xy += o.xy;
  }
};

/// Kernel that interpolates from the mesh: adds the mesh's field and potential at charges (or at dipoles alone) to
/// `field_at_source`, without those of their own clouds. For charges with dipoles it also adds the force. A block
/// handles a tile (part of the box), a thread a plane of a charge's points.
template <int order, Kind kind>
struct Gather {
  static constexpr bool forces = kind == Kind::multipoles;
  static constexpr int batch = (forces ? 512 : 1024) / order;  ///< Number of charges whose weights are stored at a time
  Tiles tiles;
  Weigher<order> window;
  const PointCharge* charges;
  const float* mesh;
  FieldSample* field_at_source;
  Totals* totals;  ///< Receives the totals; null: no totals
  float inverse_spacing[3], self, wave[2][3];
  const Moment* moments;
  FieldSample* force;
  float self_field, inverse_separation2;
  double energy_grid = fine_grid;

  /// Weights of a charge's points along the axes, with their slopes and curvatures, and the charge's first point.
  struct Weights {
    float weight[3][order], slope[3][order];
    float curvature[forces ? 3 : 1][forces ? order : 1];
    int at[3];
  };
  /// Base of PotentialTerms without second derivatives.
  struct NoCurvature {};
  /// Potential of the mesh at a charge, its slopes per spacing, and its second derivatives if forces are requested.
  struct alignas(forces ? 4 : 16) PotentialTerms : std::conditional_t<forces, Curvature, NoCurvature> {
    float x = 0, y = 0, z = 0, potential = 0;

    LICHTENBERG_HOST_DEVICE void operator+=(const PotentialTerms& o) {
      if constexpr (forces) Curvature::operator+=(o);
      x += o.x, y += o.y, z += o.z, potential += o.potential;
    }
  };
  /// Returns the fast memory of a block (bytes).
  static std::size_t bytes(const Tiles& tiles) {
    return sizeof(float) * tiles.region() + batch * (sizeof(Weights) + order * sizeof(PotentialTerms)) +
           alignof(FieldSample);
  }

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int tile) const {
    PotentialTerms* parts = block.template memory<PotentialTerms>();
    Weights* weights = reinterpret_cast<Weights*>(parts + batch * order);
    float* local = reinterpret_cast<float*>(weights + batch);
    const int from[3] = {tiles.low(tile, 0), tiles.low(tile, 1), tiles.low(tile, 2)};
    const int begin = tiles.begin(tile), end = tiles.begin(tile + 1);
    if (begin == end) return;
    Totals sum;
    block.template each<8>(tiles.region(), [&](int k) { local[k] = mesh[tiles.global(from, k)]; });
    for (int first = begin; first < end; first += batch) {
      const int now = end - first < batch ? end - first : batch;
      block.each(3 * now, [&](int k) { weigh(weights[k / 3], k % 3, charges[tiles.charge[first + k / 3]], from); });
      block.each(now * order, [&](int k) { parts[k] = plane(weights[k / order], k % order, local); });
      block.each(now, [&](int k) {
        PotentialTerms all;
        LICHTENBERG_UNROLL(8)
        for (int a = 0; a < order; ++a) all += parts[k * order + a];
        add(tiles.charge[first + k], all, sum);
      });
    }
    if (totals) block.sum(sum, [&](const Totals& all) { totals->add(all); });
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, const PointCharge& of, const int* from) const {
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    float weight[order], slope[order];
    window.weights(at.from_middle, weight, slope);
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) to.weight[axis][c] = weight[c], to.slope[axis][c] = slope[c];
    if constexpr (forces) curvatures(window, at.from_middle, to.curvature[axis]);
    to.at[axis] = tiles.local(at.point, from[axis], axis);
  }
  /// Computes the contribution of the a-th plane of a charge's points to the interpolated potential and its
  /// derivatives.
  LICHTENBERG_HOST_DEVICE PotentialTerms plane(const Weights& of, int a, const float* local) const {
    const int from = tiles.wrapped(of.at[0] + a, 0) * tiles.size[1], j = of.at[1], l = of.at[2];
    float wz[order], sz[order], cz[order];
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) {
      wz[c] = of.weight[2][c], sz[c] = of.slope[2][c];
      if constexpr (forces) cz[c] = of.curvature[2][c];
    }
    const bool wraps = l + order > tiles.points[2];
    float here = 0, y = 0, z = 0, yy = 0, zz = 0, yz = 0;
    LICHTENBERG_UNROLL(8)
    for (int b = 0; b < order; ++b) {
      const float* row = local + (from + tiles.wrapped(j + b, 1)) * tiles.size[2];
      float value = 0, slope = 0, curvature = 0;
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) {
        const float point = row[wraps ? tiles.wrapped(l + c, 2) : l + c];
        value += wz[c] * point, slope += sz[c] * point;
        if constexpr (forces) curvature += cz[c] * point;
      }
      const float w = of.weight[1][b], s = of.slope[1][b];
      here += w * value, y += s * value, z += w * slope;
      if constexpr (forces) yy += of.curvature[1][b] * value, zz += w * curvature, yz += s * slope;
    }
    const float w = of.weight[0][a], s = of.slope[0][a];
    PotentialTerms part;
    if constexpr (forces)
      static_cast<Curvature&>(part) = {of.curvature[0][a] * here, w * yy, w * zz, w * yz, s * z, s * y};
    part.x = s * here, part.y = w * y, part.z = w * z, part.potential = w * here;
    return part;
  }
  LICHTENBERG_HOST_DEVICE SelfTerm<float> own(std::uint32_t coordinate, int axis) const {
    constexpr float pi = 3.14159265f;
    const float u = OnMesh(coordinate, tiles.points[axis]).from_middle;
    float sine = 0, cosine = 0;
#ifdef __CUDA_ARCH__
    sincospif(2 * u, &sine, &cosine);
#else
    sine = std::sin(2 * pi * u), cosine = std::cos(2 * pi * u);
#endif
    return self_term<float>(cosine, -pi * sine, wave[0][axis], wave[1][axis], inverse_spacing[axis]);
  }
  /// Adds -grad of the mesh potential to the field of charge s, and -(q grad + mu.grad grad) of this potential to the
  /// force. The part of the source's own cloud is excluded (ChargeMesh::own_part).
  LICHTENBERG_HOST_DEVICE void add(int s, const PotentialTerms& d, Totals& sum) const {
    const float* h = inverse_spacing;
    const PointCharge of = charges[s];
    FieldSample to = field_at_source[s];
    if constexpr (kind == Kind::dipoles) {
      const Moment m = moments[s];
      to.x += self_field * m.x - d.x * h[0];
      to.y += self_field * m.y - d.y * h[1];
      to.z += self_field * m.z - d.z * h[2];
      field_at_source[s] = to;
      return;
    }
    const float q = of.charge;
    const SelfTerm<float> x = own(of.at.x, 0), y = own(of.at.y, 1), z = own(of.at.z, 2);
    to.x += q * x.half_slope - d.x * h[0];
    to.y += q * y.half_slope - d.y * h[1];
    to.z += q * z.half_slope - d.z * h[2];
    to.potential += d.potential - q * (self + x.potential + y.potential + z.potential);
    if constexpr (kind == Kind::charges) {
      field_at_source[s] = to;
      if (totals) sum += terms_of(of, to, energy_grid);
    }
    if constexpr (forces) {
      const Moment m = moments[s];
      const float mx = m.x * h[0], my = m.y * h[1], mz = m.z * h[2];
      to.x += self_field * m.x, to.y += self_field * m.y, to.z += self_field * m.z;
      to.potential -= m.x * x.half_slope + m.y * y.half_slope + m.z * z.half_slope;
      field_at_source[s] = to;
      FieldSample& on = force[s];
      on.x += q * (q * x.half_slope + 0.5f * x.curvature * m.x) - (q * d.x + d.xx * mx + d.xy * my + d.zx * mz) * h[0];
      on.y += q * (q * y.half_slope + 0.5f * y.curvature * m.y) - (q * d.y + d.xy * mx + d.yy * my + d.yz * mz) * h[1];
      on.z += q * (q * z.half_slope + 0.5f * z.curvature * m.z) - (q * d.z + d.zx * mx + d.yz * my + d.zz * mz) * h[2];
      sum += terms_of(of, m, to, on, inverse_separation2);
    }
  }
};

}  // namespace lichtenberg::periodic::device
