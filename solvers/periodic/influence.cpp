#include "solvers/periodic/influence.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::periodic {

namespace {

/// Modes that a mesh cannot distinguish (aliases) differ by multiples of 2 pi / spacing. Sums over windows alone
/// include aliases up to `far_aliases`, since splines of order 4 leave 1e-7 of the seventh. Sums with the cloud stop at
/// `near_aliases`: for usable meshes the cloud has nothing left of the second.
constexpr int far_aliases = WindowTransform::far_aliases, near_aliases = 1;

/// Sums over the aliases of modes 0 to points / 2 along one axis of a mesh.
struct Axis {
  struct Mode {
    double u2 = 0, k2u2 = 0, k4u2 = 0;  ///< Sums of U^2, k^2 U^2 and k^4 U^2; U is the window's transform
    std::array<double, 2> shifted{};    ///< Sums of U(m) U(m + 1) and of U(m) U(m + 2)
    std::array<double, 2 * near_aliases + 1> k2{}, square{};  ///< k^2 and U^2 of each alias
  };
  std::vector<Mode> modes;

  Axis(double length, int points, const WindowTransform& transform) {
    for (int mode = 0; mode <= points / 2; ++mode) {
      const WindowTransform::Aliases window = transform.at_mode(mode, points);
      Mode& sums = modes.emplace_back();
      for (int m = -far_aliases; m <= far_aliases; ++m) {
        const double k = 2 * M_PI * (mode + static_cast<double>(m) * points) / length, u = window[m + far_aliases];
        sums.u2 += u * u;
        sums.k2u2 += k * k * u * u;
        sums.k4u2 += k * k * k * k * u * u;
        if (std::abs(m) > near_aliases) continue;
        sums.k2[m + near_aliases] = k * k;
        sums.square[m + near_aliases] = u * u;
      }
      for (int n = 1; n <= 2; ++n)
        for (int m = 0; m + n <= 2 * far_aliases; ++m) sums.shifted[n - 1] += window[m] * window[m + n];
    }
  }
};

/// Sums over all aliases of a mode on the mesh.
struct AliasSums {
  double u2 = 0;        ///< U^2
  double k2u2 = 0;      ///< k^2 U^2
  double cloud_u2 = 0;  ///< 4 pi w U^2: (k U)^2 times the smooth part's transform
  double force2 = 0;    ///< (4 pi w / k)^2

  double factor() const { return cloud_u2 / (u2 * k2u2); }
};

/// Calls use(k^2, U^2, 4 pi w) for the aliases within the cloud's band limit.
template <class Use>
void visit_aliases(const Axis::Mode& x, const Axis::Mode& y, const Axis::Mode& z, const Cloud& cloud, Use&& use) {
  const double limit = cloud.band_limit * cloud.band_limit;
  for (std::size_t a = 0; a < x.k2.size(); ++a)
    for (std::size_t b = 0; b < y.k2.size(); ++b)
      for (std::size_t c = 0; c < z.k2.size(); ++c) {
        const double k2 = x.k2[a] + y.k2[b] + z.k2[c];
        if (k2 <= limit) use(k2, x.square[a] * y.square[b] * z.square[c], 4 * M_PI * cloud.transform(std::sqrt(k2)));
      }
}

AliasSums sum_aliases(const Axis::Mode& x, const Axis::Mode& y, const Axis::Mode& z, const Cloud& cloud) {
  AliasSums sums;
  sums.u2 = x.u2 * y.u2 * z.u2;
  sums.k2u2 = x.k2u2 * y.u2 * z.u2 + x.u2 * y.k2u2 * z.u2 + x.u2 * y.u2 * z.k2u2;
  visit_aliases(x, y, z, cloud, [&](double k2, double u2, double w) {
    sums.cloud_u2 += w * u2;
    sums.force2 += w * w / k2;
  });
  return sums;
}

/// Returns the squared error of the force due to aliases, for charges with dipoles of mean square 3 `third`. The source
/// in mode m and the target in mode n count 1 + third k^2 each; only the terms with m = n belong to the exact force.
double error_with_dipoles(const Axis::Mode& x, const Axis::Mode& y, const Axis::Mode& z, const Cloud& cloud,
                          double factor, double third) {
  const double u2 = x.u2 * y.u2 * z.u2;
  const double k2u2 = x.k2u2 * y.u2 * z.u2 + x.u2 * y.k2u2 * z.u2 + x.u2 * y.u2 * z.k2u2;
  const double k4u2 = x.k4u2 * y.u2 * z.u2 + x.u2 * y.k4u2 * z.u2 + x.u2 * y.u2 * z.k4u2 +
                      2 * (x.k2u2 * y.k2u2 * z.u2 + x.k2u2 * y.u2 * z.k2u2 + x.u2 * y.k2u2 * z.k2u2);
  double error = factor * factor * (u2 + third * k2u2) * (k2u2 + third * k4u2);
  visit_aliases(x, y, z, cloud, [&](double k2, double square, double w) {
    const double both = (1 + third * k2) * (1 + third * k2);
    error += both * w * (w / k2 - 2 * factor * square);
  });
  return error;
}

struct Octant {
  std::array<Axis, 3> axes;

  explicit Octant(const Mesh& mesh) : Octant(mesh, WindowTransform::of(mesh.window, mesh.order)) {}
  Octant(const Mesh& mesh, const WindowTransform& transform)
      : axes{Axis(mesh.lengths.x, mesh.points[0], transform), Axis(mesh.lengths.y, mesh.points[1], transform),
             Axis(mesh.lengths.z, mesh.points[2], transform)} {}

  /// Calls use(modes, `AliasSums`, number of mirror images of the mode on the mesh) for all modes except the constant.
  template <class Use>
  void visit(const Mesh& mesh, const Cloud& cloud, Use&& use) const {
    const auto images = [&](int axis, int mode) { return mode == 0 || 2 * mode == mesh.points[axis] ? 1 : 2; };
    for (int y = 0; y <= mesh.points[1] / 2; ++y)
      for (int x = 0; x <= mesh.points[0] / 2; ++x)
        for (int z = 0; z <= mesh.points[2] / 2; ++z)
          if (x + y + z > 0)
            use(std::array{x, y, z}, sum_aliases(axes[0].modes[x], axes[1].modes[y], axes[2].modes[z], cloud),
                images(0, x) * images(1, y) * images(2, z));
  }
};

double mesh_error(const Mesh& mesh, const Cloud& cloud, const Octant& octant, double dipole2) {
  double sum = 0;
  octant.visit(mesh, cloud, [&](std::array<int, 3> mode, const AliasSums& sums, int images) {
    const auto along = [&](int k) -> const Axis::Mode& { return octant.axes[k].modes[mode[k]]; };
    const double error = dipole2 > 0
                             ? error_with_dipoles(along(0), along(1), along(2), cloud, sums.factor(), dipole2 / 3)
                             : sums.force2 - sums.cloud_u2 * sums.factor();
    sum += images * std::max(0.0, error);
  });
  return sum / mesh.volume();
}

}  // namespace

double green_transform(Vec3 k, const OpenAxes& open) {
  double across2 = 0, along2 = 0;  // squares of the wave vector's parts along open and periodic axes
  for (int axis = 0; axis < 3; ++axis) (open.along[axis] ? across2 : along2) += k[axis] * k[axis];
  const int axes = open.along[0] + open.along[1] + open.along[2];
  const double q = std::sqrt(across2), p = std::sqrt(along2), k2 = across2 + along2, range = open.range, x = q * range;
  const double square = range * range;
  if (k2 == 0 && axes < 3)
    return axes == 0 ? 0 : axes == 1 ? -2 * M_PI * square : M_PI * square * (1 - 2 * std::log(range));
  if (k2 == 0) return 2 * M_PI * square;
  // Transforms over the open axes of 1/r, of 2 K_0(p r) or -2 log r, and of 2 pi exp(-p |z|) / p or -2 pi |z|.
  double ratio = 1;
  if (axes == 3) ratio = 1 - std::cos(x);
  if (axes == 2 && p > 0 && p * range < 100)
    ratio =
        1 + x * ::j1(x) * std::cyl_bessel_k(0.0, p * range) - p * range * ::j0(x) * std::cyl_bessel_k(1.0, p * range);
  if (axes == 2 && p == 0) ratio = 1 - ::j0(x) - x * std::log(range) * ::j1(x);
  if (axes == 1 && p > 0) ratio = 1 - std::exp(-p * range) * (std::cos(x) - q / p * std::sin(x));
  if (axes == 1 && p == 0) ratio = 1 - std::cos(x) - x * std::sin(x);
  return 4 * M_PI / k2 * ratio;
}

Influence optimal_influence(const Mesh& mesh, const Cloud& cloud) {
  const int across = mesh.points[0], down = mesh.points[1], deep = mesh.points[2] / 2 + 1;
  Influence influence;
  influence.factor.resize(static_cast<std::size_t>(across) * down * deep);
  const Octant octant(mesh);
  if (mesh.open.any())  // the mean potential; without open axes it is 0
    influence.factor[0] = green_transform({}, mesh.open) / (octant.axes[0].modes[0].u2 * octant.axes[1].modes[0].u2 *
                                                            octant.axes[2].modes[0].u2 * mesh.volume());
  octant.visit(mesh, cloud, [&](std::array<int, 3> mode, const AliasSums& sums, int images) {
    const auto [x, y, z] = mode;
    double factor = sums.factor() / mesh.volume();
    if (mesh.open.any()) {
      const Vec3 k{2 * M_PI * x / mesh.lengths.x, 2 * M_PI * y / mesh.lengths.y, 2 * M_PI * z / mesh.lengths.z};
      factor *= green_transform(k, mesh.open) * norm2(k) / (4 * M_PI);
    }
    for (const int row : {y, (down - y) % down})
      for (const int column : {x, (across - x) % across})
        influence.factor[(static_cast<std::size_t>(row) * across + column) * deep + z] = factor;
    for (int k = 0; k < 3; ++k) {
      const auto& along = octant.axes[k].modes[mode[k]];
      for (int n = 0; n < 2; ++n)
        influence.self_wave[k][n] += images * 2 * factor * sums.u2 / along.u2 * along.shifted[n];
    }
  });
  return influence;
}

double mesh_error(const Mesh& mesh, const Cloud& cloud, double dipole2) {
  return mesh_error(mesh, cloud, Octant(mesh), dipole2);
}

double mesh_error(const Mesh& mesh, const Cloud& cloud, const WindowTransform& window) {
  return mesh_error(mesh, cloud, Octant(mesh, window), 0);
}

}  // namespace lichtenberg::periodic
