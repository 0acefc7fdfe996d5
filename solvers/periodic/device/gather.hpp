#pragma once

// From a mesh of potentials to what charges feel.

#include "solvers/periodic/device/near.hpp"
#include "solvers/periodic/device/tiles.hpp"
#include "solvers/periodic/device/totals.hpp"
#include "solvers/periodic/device/window.hpp"

namespace lichtenberg::periodic::device {

/// Adds field and potential of a mesh of potentials to what charges feel, without that of their own clouds. A block a
/// tile, a thread a plane of a charge's points.
template <int order>
struct Gather {
  static constexpr int batch = 1024 / order;  ///< charges whose weights are kept
  Tiles tiles;
  Weigher<order> window;
  const Charged* charges;
  const float* mesh;
  Felt* felt;
  Totals* totals;  ///< to which all is added up; null: nothing is
  float over_spacing[3], self, wave[2][3];
  const Moment* moments = nullptr;  ///< of the dipoles alone, without charges; null: of charges
  float self_field = 0;

  struct Weights {
    float weight[3][order], slope[3][order];
    int at[3];
  };
  static std::size_t bytes(const Tiles& tiles) {
    return sizeof(float) * tiles.region() + batch * (sizeof(Weights) + order * sizeof(Felt)) + alignof(Felt);
  }

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int tile) const {
    Felt* parts = block.template memory<Felt>();
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
        const int s = tiles.charge[first + k];
        Felt all;
        LICHTENBERG_UNROLL(8)
        for (int a = 0; a < order; ++a) {
          const Felt part = parts[k * order + a];
          all.x += part.x, all.y += part.y, all.z += part.z, all.potential += part.potential;
        }
        if (moments) {
          const Moment m = moments[s];
          felt[s].x += self_field * m.x - all.x * over_spacing[0];
          felt[s].y += self_field * m.y - all.y * over_spacing[1];
          felt[s].z += self_field * m.z - all.z * over_spacing[2];
        } else {
          float half[3], bend[3];
          Felt feels = felt[s];
          const Charged of = charges[s];
          add(feels, of, all, half, bend);
          felt[s] = feels;
          if (totals) sum += terms_of(of, feels);
        }
      });
    }
    if (totals) block.sum(sum, [&](const Totals& all) { totals->add(all); });
  }

  /// `sum`: over all planes. Half the slope and the curvature of its own cloud's potential come back.
  LICHTENBERG_HOST_DEVICE void add(Felt& to, const Charged& of, const Felt& sum, float* half, float* bend) const {
    const OnMesh x(of.at.x, tiles.points[0]), y(of.at.y, tiles.points[1]), z(of.at.z, tiles.points[2]);
    float own = self;
    own += own_wave(x.from_middle, 0, half[0], bend[0]);
    own += own_wave(y.from_middle, 1, half[1], bend[1]);
    own += own_wave(z.from_middle, 2, half[2], bend[2]);
    to.x += of.charge * half[0] - sum.x * over_spacing[0];
    to.y += of.charge * half[1] - sum.y * over_spacing[1];
    to.z += of.charge * half[2] - sum.z * over_spacing[2];
    to.potential += sum.potential - of.charge * own;
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, const Charged& of, const int* from) const {
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    float weight[order], slope[order];
    window.weights(at.from_middle, weight, slope);
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) to.weight[axis][c] = weight[c], to.slope[axis][c] = slope[c];
    to.at[axis] = tiles.local(at.point, from[axis], axis);
  }
  /// What the a-th plane of a charge's points gives: slopes by mesh points, and the potential.
  LICHTENBERG_HOST_DEVICE Felt plane(const Weights& of, int a, const float* local) const {
    const int from = tiles.wrapped(of.at[0] + a, 0) * tiles.size[1], j = of.at[1], l = of.at[2];
    float wz[order], sz[order];
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) wz[c] = of.weight[2][c], sz[c] = of.slope[2][c];
    const bool wraps = l + order > tiles.points[2];
    float here = 0, slope_y = 0, slope_z = 0;
    LICHTENBERG_UNROLL(8)
    for (int b = 0; b < order; ++b) {
      const float* row = local + (from + tiles.wrapped(j + b, 1)) * tiles.size[2];
      float value = 0, slope = 0;
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) {
        const float point = row[wraps ? tiles.wrapped(l + c, 2) : l + c];
        value += wz[c] * point, slope += sz[c] * point;
      }
      here += of.weight[1][b] * value, slope_y += of.slope[1][b] * value, slope_z += of.weight[1][b] * slope;
    }
    return {of.slope[0][a] * here, of.weight[0][a] * slope_y, of.weight[0][a] * slope_z, of.weight[0][a] * here};
  }
  /// What splines make a unit charge see of its own cloud beyond the mean, u from the middle between two points, half
  /// its slope (half, for the cloud moves with the charge) and its curvature.
  LICHTENBERG_HOST_DEVICE float own_wave(float u, int axis, float& half_slope, float& curvature) const {
    constexpr float pi = 3.14159265f;
    float sine = 0, cosine = 0;
#ifdef __CUDA_ARCH__
    sincospif(2 * u, &sine, &cosine);
#else
    sine = std::sin(2 * pi * u), cosine = std::cos(2 * pi * u);
#endif
    const float twice = 2 * cosine * cosine - 1, h = over_spacing[axis];
    half_slope = -pi * sine * (wave[0][axis] + 4 * wave[1][axis] * cosine) * h;
    curvature = -4 * pi * pi * (wave[0][axis] * cosine + 4 * wave[1][axis] * twice) * h * h;
    return wave[0][axis] * cosine + wave[1][axis] * twice;
  }
};

/// Potential and its derivatives by mesh points.
struct Derivatives {
  float value = 0, x = 0, y = 0, z = 0, xx = 0, yy = 0, zz = 0, yz = 0, zx = 0, xy = 0;

  LICHTENBERG_HOST_DEVICE Derivatives& operator+=(const Derivatives& o) {
    value += o.value, x += o.x, y += o.y, z += o.z;
    xx += o.xx, yy += o.yy, zz += o.zz, yz += o.yz, zx += o.zx, xy += o.xy;
    return *this;
  }
};

/// The same of charges with dipoles, and the forces on them. A block a tile, a thread a plane of a charge's points.
template <int order>
struct GatherForces {
  static constexpr int batch = 512 / order;  ///< charges whose weights are kept
  Gather<order> of_charges;
  const Moment* moments;
  Felt* force;
  float self_field, over_apart2;

  struct Weights {
    float weight[3][order], slope[3][order], curvature[3][order];
    int at[3];
  };
  static std::size_t bytes(const Tiles& tiles) {
    return sizeof(float) * tiles.region() + batch * (sizeof(Weights) + order * sizeof(Derivatives)) + alignof(Felt);
  }

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int tile) const {
    const Tiles& tiles = of_charges.tiles;
    Derivatives* parts = block.template memory<Derivatives>();
    Weights* weights = reinterpret_cast<Weights*>(parts + batch * order);
    float* local = reinterpret_cast<float*>(weights + batch);
    const int from[3] = {tiles.low(tile, 0), tiles.low(tile, 1), tiles.low(tile, 2)};
    const int begin = tiles.begin(tile), end = tiles.begin(tile + 1);
    if (begin == end) return;
    Totals sum;
    block.template each<8>(tiles.region(), [&](int k) { local[k] = of_charges.mesh[tiles.global(from, k)]; });
    for (int first = begin; first < end; first += batch) {
      const int now = end - first < batch ? end - first : batch;
      block.each(3 * now,
                 [&](int k) { weigh(weights[k / 3], k % 3, of_charges.charges[tiles.charge[first + k / 3]], from); });
      block.each(now * order, [&](int k) { parts[k] = plane(weights[k / order], k % order, local); });
      block.each(now, [&](int k) {
        Derivatives all;
        LICHTENBERG_UNROLL(8)
        for (int a = 0; a < order; ++a) all += parts[k * order + a];
        const int s = tiles.charge[first + k];
        add(s, all);
        sum += terms_of(of_charges.charges[s], moments[s], of_charges.felt[s], force[s], over_apart2);
      });
    }
    block.sum(sum, [&](const Totals& all) { of_charges.totals->add(all); });
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, const Charged& of, const int* from) const {
    const Tiles& tiles = of_charges.tiles;
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    of_charges.window.weights(at.from_middle, to.weight[axis], to.slope[axis]);
    curvatures(of_charges.window, at.from_middle, to.curvature[axis]);
    to.at[axis] = tiles.local(at.point, from[axis], axis);
  }
  LICHTENBERG_HOST_DEVICE Derivatives plane(const Weights& of, int a, const float* local) const {
    const Tiles& tiles = of_charges.tiles;
    const int from = tiles.wrapped(of.at[0] + a, 0) * tiles.size[1], j = of.at[1], l = of.at[2];
    float here = 0, y = 0, z = 0, yy = 0, zz = 0, yz = 0;
    LICHTENBERG_UNROLL(8)
    for (int b = 0; b < order; ++b) {
      const float* row = local + (from + tiles.wrapped(j + b, 1)) * tiles.size[2];
      float value = 0, slope = 0, curvature = 0;
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) {
        const float point = row[tiles.wrapped(l + c, 2)];
        value += of.weight[2][c] * point, slope += of.slope[2][c] * point, curvature += of.curvature[2][c] * point;
      }
      const float w = of.weight[1][b], s = of.slope[1][b];
      here += w * value, y += s * value, z += w * slope;
      yy += of.curvature[1][b] * value, zz += w * curvature, yz += s * slope;
    }
    const float w = of.weight[0][a], s = of.slope[0][a];
    return {w * here, s * here, w * y, w * z, of.curvature[0][a] * here, w * yy, w * zz, w * yz, s * z, s * y};
  }
  /// -(q grad + mu.grad grad) of the potential, without what the charge and its dipole do to themselves
  /// (ChargeMesh::take_multipole_off).
  LICHTENBERG_HOST_DEVICE void add(int s, const Derivatives& d) const {
    const float* h = of_charges.over_spacing;
    const Charged of = of_charges.charges[s];
    const Moment m = moments[s];
    const float mx = m.x * h[0], my = m.y * h[1], mz = m.z * h[2], q = of.charge;
    Felt& to = of_charges.felt[s];
    float half[3], bend[3];
    of_charges.add(to, of, {d.x, d.y, d.z, d.value}, half, bend);
    to.x += self_field * m.x, to.y += self_field * m.y, to.z += self_field * m.z;
    to.potential -= m.x * half[0] + m.y * half[1] + m.z * half[2];
    force[s].x += q * (q * half[0] + 0.5f * bend[0] * m.x) - (q * d.x + d.xx * mx + d.xy * my + d.zx * mz) * h[0];
    force[s].y += q * (q * half[1] + 0.5f * bend[1] * m.y) - (q * d.y + d.xy * mx + d.yy * my + d.yz * mz) * h[1];
    force[s].z += q * (q * half[2] + 0.5f * bend[2] * m.z) - (q * d.z + d.zx * mx + d.yz * my + d.zz * mz) * h[2];
  }
};

}  // namespace lichtenberg::periodic::device
