#pragma once

// Charges on a mesh, on an executor: spread by tiles of the box in fast memory with whole numbers, so that sums have
// the same bits in any order; transforms; and back by the same tiles.

#include <cmath>

#include "solvers/periodic/device/fft.hpp"
#include "solvers/periodic/device/near.hpp"

namespace lichtenberg::periodic::device {

/// Weights of a charge's points along one axis, by what lies behind the point before it.
template <int order>
struct Window {
  float term[order][order];  ///< of t^d in the c-th weight: [d][c]

  LICHTENBERG_HOST_DEVICE void weights(float t, float* weight) const {
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) {
      float value = term[order - 1][c];
      LICHTENBERG_UNROLL(8)
      for (int d = order - 2; d >= 0; --d) value = value * t + term[d][c];
      weight[c] = value;
    }
  }
  /// And their derivatives by t.
  LICHTENBERG_HOST_DEVICE void weights(float t, float* weight, float* slope) const {
    LICHTENBERG_UNROLL(8)
    for (int c = 0; c < order; ++c) {
      float value = term[order - 1][c], by_t = 0;
      LICHTENBERG_UNROLL(8)
      for (int d = order - 2; d >= 0; --d) by_t = by_t * t + value, value = value * t + term[d][c];
      weight[c] = value, slope[c] = by_t;
    }
  }
};

/// Second derivatives of these weights.
template <int order>
LICHTENBERG_HOST_DEVICE void curvatures(const Window<order>& window, float t, float* curvature) {
  LICHTENBERG_UNROLL(8)
  for (int c = 0; c < order; ++c) {
    float value = 0;
    LICHTENBERG_UNROLL(8)
    for (int d = order - 1; d >= 2; --d) value = value * t + static_cast<float>(d * (d - 1)) * window.term[d][c];
    curvature[c] = value;
  }
}

/// What is spread and gathered: as Kind of the CPU's.
enum class Sought { of_charges, of_dipoles, forces };

/// A place on the mesh along one axis: the point before it, and how far behind that it lies.
struct OnMesh {
  int point = 0;
  float behind = 0;

  LICHTENBERG_HOST_DEVICE OnMesh(std::uint32_t turns, int points) {
    const std::uint64_t product = static_cast<std::uint64_t>(turns) * static_cast<std::uint64_t>(points);
    point = static_cast<int>(product >> 32);
    behind = static_cast<float>(static_cast<std::uint32_t>(product)) * 0x1p-32f;
    // Rounded up to the next point, it lies at the end of this one.
    if (behind > 0x1.fffffep-1f) behind = 0x1.fffffep-1f;
  }
};

LICHTENBERG_HOST_DEVICE inline int whole(float value) {
#ifdef __CUDA_ARCH__
  return __float2int_rn(value);
#else
  return static_cast<int>(std::nearbyint(value));
#endif
}

/// How many tiles of about `wanted` points there are along an axis.
inline int tiles_along(int points, int wanted) {
  return std::max(1, static_cast<int>(std::lround(static_cast<double>(points) / wanted)));
}

/// Edges of cells for lists of partners within the cutoff and a little more, as many along an axis as tiles of 16
/// points make of it.
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

/// Tiles of the box, each a block of cells with the points of the mesh that its charges reach, even if they have moved
/// by some points since they were sorted into cells.
struct Tiles {
  CellsView cells;
  int points[3], group[3], tiles[3];  ///< points of the mesh; cells a tile and tiles along an axis
  int size[3];                        ///< points that a tile's charges reach
  int moved[3];                       ///< points that they may have moved
  const int *first, *charge;          ///< of a tile's charges, all tiles' one after the other; [tiles * runs + 1], [N]
  float over_plane, over_row;         ///< 1 / points of a region's plane and row, a little more

  int count() const { return tiles[0] * tiles[1] * tiles[2]; }
  LICHTENBERG_HOST_DEVICE int region() const { return size[0] * size[1] * size[2]; }
  LICHTENBERG_HOST_DEVICE int runs() const { return group[0] * group[1]; }
  LICHTENBERG_HOST_DEVICE int begin(int tile) const { return first[tile * runs()]; }

  LICHTENBERG_HOST_DEVICE int cell(int tile, int axis) const {
    const int at = axis == 0 ? tile / (tiles[1] * tiles[2]) : axis == 1 ? tile / tiles[2] % tiles[1] : tile % tiles[2];
    return at * group[axis];
  }
  LICHTENBERG_HOST_DEVICE int low(int tile, int axis) const {
    return static_cast<int>(static_cast<long>(cell(tile, axis)) * points[axis] / cells.cells[axis]) - moved[axis];
  }
  /// Of a point of the mesh, in a region that begins at `from`.
  LICHTENBERG_HOST_DEVICE int local(int point, int from, int axis) const {
    const int d = point - from;
    return d < 0 ? d + points[axis] : d >= points[axis] ? d - points[axis] : d;
  }
  LICHTENBERG_HOST_DEVICE int wrapped(int local, int axis) const {
    return local >= points[axis] ? local - points[axis] : local;
  }
  /// Point of the mesh of a region's k-th.
  LICHTENBERG_HOST_DEVICE int global(const int* from, int k) const {
    // Whole numbers of 20 bits over others, without a division.
    const int plane = static_cast<int>(static_cast<float>(k) * over_plane), in_plane = k - plane * size[1] * size[2];
    const int row = static_cast<int>(static_cast<float>(in_plane) * over_row);
    const int x = wrapped_global(from[0] + plane, 0), y = wrapped_global(from[1] + row, 1),
              z = wrapped_global(from[2] + in_plane - row * size[2], 2);
    return (x * points[1] + y) * points[2] + z;
  }

  /// Of sorted charges: where those of a column of cells within a tile begin, and end.
  LICHTENBERG_HOST_DEVICE void run(int tile, int r, int& begin, int& end) const {
    const int x = cell(tile, 0) + r / group[1], y = cell(tile, 1) + r % group[1], z = cell(tile, 2);
    begin = end = 0;
    if (x >= cells.cells[0] || y >= cells.cells[1]) return;
    const int last = z + group[2] < cells.cells[2] ? z + group[2] : cells.cells[2];
    begin = cells.first[cells.number(x, y, z)];
    end = cells.first[cells.number(x, y, 0) + last];
  }

 private:
  LICHTENBERG_HOST_DEVICE int wrapped_global(int point, int axis) const {
    return point < 0 ? point + points[axis] : point >= points[axis] ? point - points[axis] : point;
  }
};

/// Adds charges, dipoles or both to a mesh of whole numbers, `unit` of them a charge. A block a tile. A dipole's
/// potential is mu.grad of a charge's by its own place, so it is spread with mu.grad of the weights.
template <int order, Sought sought = Sought::of_charges>
struct Spread {
  static constexpr int batch = 256;  ///< charges whose weights are kept
  Tiles tiles;
  Window<order> window;
  const Charged* charges;
  int* mesh;
  float unit;
  const Moment* moments = nullptr;
  float over_spacing[3] = {};

  static constexpr bool dipoles = sought != Sought::of_charges;
  static std::size_t bytes(const Tiles& tiles) { return sizeof(int) * tiles.region() + batch * sizeof(Weights); }
  struct Weights {
    float weight[3][order];
    float slope[dipoles ? 3 : 1][dipoles ? order : 1];  ///< times the dipole
    int at[3];
    float charge;
  };

  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int tile) const {
    Weights* weights = block.template memory<Weights>();
    int* local = reinterpret_cast<int*>(weights + batch);
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
    const Charged of = charges[s];
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    float weight[order];
    if constexpr (dipoles) {
      float slope[order];
      window.weights(at.behind, weight, slope);
      const Moment m = moments[s];
      const float factor = over_spacing[axis] * (axis == 0 ? m.x : axis == 1 ? m.y : m.z);
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) to.weight[axis][c] = weight[c], to.slope[axis][c] = factor * slope[c];
      if (axis == 0) to.charge = sought == Sought::forces ? of.charge : 0;
    } else {
      window.weights(at.behind, weight);
      const float factor = axis == 0 ? unit * of.charge : 1;
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c) to.weight[axis][c] = factor * weight[c];
    }
    to.at[axis] = tiles.local(at.point, from[axis], axis);
  }
  /// The a-th plane of a charge's points.
  LICHTENBERG_HOST_DEVICE void spread(const Weights& of, int a, int* local) const {
    const int plane = tiles.wrapped(of.at[0] + a, 0) * tiles.size[1];
    float y[order], z[order];  // what is added to might lie where the weights do, for all that a compiler knows
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
      int* row = local + (plane + tiles.wrapped(j + b, 1)) * tiles.size[2];
      LICHTENBERG_UNROLL(8)
      for (int c = 0; c < order; ++c)
        parallel::add_atomically(
            &row[wraps ? tiles.wrapped(l + c, 2) : l + c],
            whole(dipoles ? y[b] * z[c] + moved[dipoles ? b : 0] * also[dipoles ? c : 0] : y[b] * z[c]));
    }
  }
};

/// Adds field and potential of a mesh of potentials to what charges feel, without that of their own clouds. A block a
/// tile, a thread a plane of a charge's points.
template <int order>
struct Gather {
  static constexpr int batch = 1024 / order;  ///< charges whose weights are kept
  Tiles tiles;
  Window<order> window;
  const Charged* charges;
  const float* mesh;
  Felt* felt;
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
          add(felt[s], charges[s], all, half, bend);
        }
      });
    }
  }

  /// `sum`: over all planes. Half the slope and the curvature of its own cloud's potential come back.
  LICHTENBERG_HOST_DEVICE void add(Felt& to, const Charged& of, const Felt& sum, float* half, float* bend) const {
    const OnMesh x(of.at.x, tiles.points[0]), y(of.at.y, tiles.points[1]), z(of.at.z, tiles.points[2]);
    float own = self;
    own += own_wave(x.behind - 0.5f, 0, half[0], bend[0]);
    own += own_wave(y.behind - 0.5f, 1, half[1], bend[1]);
    own += own_wave(z.behind - 0.5f, 2, half[2], bend[2]);
    to.x += of.charge * half[0] - sum.x * over_spacing[0];
    to.y += of.charge * half[1] - sum.y * over_spacing[1];
    to.z += of.charge * half[2] - sum.z * over_spacing[2];
    to.potential += sum.potential - of.charge * own;
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, const Charged& of, const int* from) const {
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    float weight[order], slope[order];
    window.weights(at.behind, weight, slope);
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
  float self_field;

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
        add(tiles.charge[first + k], all);
      });
    }
  }

 private:
  LICHTENBERG_HOST_DEVICE void weigh(Weights& to, int axis, const Charged& of, const int* from) const {
    const Tiles& tiles = of_charges.tiles;
    const OnMesh at(axis == 0 ? of.at.x : axis == 1 ? of.at.y : of.at.z, tiles.points[axis]);
    of_charges.window.weights(at.behind, to.weight[axis], to.slope[axis]);
    curvatures(of_charges.window, at.behind, to.curvature[axis]);
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

/// The smooth part of charges' sums.
template <class Executor>
class MeshPart {
 public:
  MeshPart(const Executor& run, const MeshTables& tables)
      : run_(&run),
        tables_(tables),
        fft_(run, tables.mesh.points),
        factor_(run),
        whole_(run),
        real_(run),
        modes_(run),
        first_(run),
        charge_(run) {
    factor_.upload(tables.factor);
    const auto [x, y, z] = tables.mesh.points;
    points_ = static_cast<long>(x) * y * z;
    whole_.resize(points_);
    real_.resize(points_);
    modes_.resize(2 * tables.factor.size());
    whole_.zero();
    // No more charge comes to a point than touching grains have: at most 1.5 in unit volume, of charge 1, with room to
    // spare, and for their dipoles. What is rounded off is 1e-8 of that.
    const Vec3 h = tables.mesh.spacing();
    unit_ = static_cast<float>(std::exp2(30 - std::ceil(std::log2(8 + 6 * h.x * h.y * h.z))));
  }

  /// For charges that are sorted in cells, and move by at most `moved` before they are sorted again.
  void arrange(int n, const CellsView& cells, double moved) {
    // Large tiles have less around them, but all of a device wants work, and two blocks a processor.
    constexpr int enough = 120, most_points = 16000;
    for (const std::array<int, 3>& points :
         {std::array{16, 16, 32}, {16, 16, 16}, {16, 16, 8}, {8, 16, 8}, {8, 8, 8}}) {
      cut(cells, moved, points);
      if (tiles_.count() >= enough && tiles_.region() <= most_points) break;
    }
    // Above 1 / n by so little that products with numbers up to 2^22 are rounded down to the right one.
    const auto above = [](int size) { return std::nextafter(1.0f / static_cast<float>(size), 1.0f); };
    tiles_.over_plane = above(tiles_.size[1] * tiles_.size[2]);
    tiles_.over_row = above(tiles_.size[2]);
    const Tiles tiles = tiles_;
    const int runs = tiles.runs(), all = tiles.count() * runs;
    first_.resize(all + 1);
    charge_.resize(n);
    int *first = first_.data(), *charge = charge_.data();
    run_->for_each(all + 1, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int begin = 0, end = 0;
      if (k < all) tiles.run(k / runs, k % runs, begin, end);
      first[k] = end - begin;
    });
    run_->exclusive_scan(first, all + 1);
    run_->for_each(all, [=] LICHTENBERG_HOST_DEVICE(int k) {
      int begin = 0, end = 0;
      tiles.run(k / runs, k % runs, begin, end);
      for (int s = begin; s < end; ++s) charge[first[k] + s - begin] = s;
    });
    tiles_.first = first;
    tiles_.charge = charge;
  }

  /// Into tiles of about so many points.
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

  // Spread, solve, gather, in this order.

  void spread(const Charged* charges) {
    with_window([&]<int order>(const Window<order>& window) {
      run_->template for_each_block<512>(tiles_.count(), Spread<order>::bytes(tiles_),
                                         Spread<order>{tiles_, window, charges, whole_.data(), unit_});
    });
  }
  /// Of dipoles alone, or of charges with dipoles.
  void spread(const Charged* charges, const Moment* moments, bool with_charges) {
    with_window([&]<int order>(const Window<order>& window) {
      with_charges ? spread_with<order, Sought::forces>(window, charges, moments)
                   : spread_with<order, Sought::of_dipoles>(window, charges, moments);
    });
  }
  void solve() {
    int* whole = whole_.data();
    float *real = real_.data(), *modes = modes_.data();
    const float *factor = factor_.data(), over_unit = 1 / unit_;
    run_->for_each(points_, [=] LICHTENBERG_HOST_DEVICE(int k) {
      real[k] = over_unit * static_cast<float>(whole[k]);
      whole[k] = 0;
    });
    fft_.forward(real, modes);
    run_->for_each(static_cast<long>(factor_.size()), [=] LICHTENBERG_HOST_DEVICE(int k) {
      modes[2 * k] *= factor[k];
      modes[2 * k + 1] *= factor[k];
    });
    fft_.backward(modes, real);
  }
  /// Adds to what the charges feel. The mesh's background is not in the potential.
  void gather(const Charged* charges, Felt* felt) {
    with_window([&]<int order>(const Window<order>& window) {
      run_->template for_each_block<512>(tiles_.count(), Gather<order>::bytes(tiles_),
                                         gather_of(window, charges, felt));
    });
  }
  /// Adds the field of dipoles alone.
  void gather_field(const Charged* charges, const Moment* moments, Felt* field) {
    with_window([&]<int order>(const Window<order>& window) {
      Gather<order> gather = gather_of(window, charges, field);
      gather.moments = moments, gather.self_field = tables_.self_field;
      run_->template for_each_block<512>(tiles_.count(), Gather<order>::bytes(tiles_), gather);
    });
  }
  /// Adds to what charges with dipoles feel, and to the forces on them.
  void gather_forces(const Charged* charges, const Moment* moments, Felt* felt, Felt* force) {
    with_window([&]<int order>(const Window<order>& window) {
      run_->template for_each_block<512>(
          tiles_.count(), GatherForces<order>::bytes(tiles_),
          GatherForces<order>{gather_of(window, charges, felt), moments, force, tables_.self_field});
    });
  }

 private:
  template <int order, Sought sought>
  void spread_with(const Window<order>& window, const Charged* charges, const Moment* moments) {
    Spread<order, sought> spread{tiles_, window, charges, whole_.data(), unit_, moments, {}};
    for (int k = 0; k < 3; ++k) spread.over_spacing[k] = tables_.over_spacing[k];
    run_->template for_each_block<512>(tiles_.count(), Spread<order, sought>::bytes(tiles_), spread);
  }
  template <int order>
  Gather<order> gather_of(const Window<order>& window, const Charged* charges, Felt* felt) const {
    Gather<order> gather{tiles_, window, charges, real_.data(), felt, {}, tables_.self, {}};
    for (int k = 0; k < 3; ++k) {
      gather.over_spacing[k] = tables_.over_spacing[k];
      gather.wave[0][k] = tables_.wave[0][k], gather.wave[1][k] = tables_.wave[1][k];
    }
    return gather;
  }
  /// work(Window) of the mesh's order.
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
  Window<order> window() const {
    Window<order> window;
    for (int d = 0; d < order; ++d)
      for (int c = 0; c < order; ++c) window.term[d][c] = tables_.window[d * order + c];
    return window;
  }

  const Executor* run_;
  MeshTables tables_;
  Fft<Executor> fft_;
  parallel::Array<float, Executor> factor_;
  parallel::Array<int, Executor> whole_;
  parallel::Array<float, Executor> real_, modes_;
  parallel::Array<int, Executor> first_, charge_;  ///< of tiles
  long points_ = 0;
  float unit_ = 1;
  Tiles tiles_{};
};

}  // namespace lichtenberg::periodic::device
