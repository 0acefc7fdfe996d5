#pragma once

#include <array>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/window.hpp"

namespace lichtenberg::periodic {

/// A mesh in a periodic box, and how charges come on it: by windows of an order.
struct Mesh {
  Vec3 lengths;  ///< of the box
  std::array<int, 3> points{};
  int order = 0;
  Window window = Window::spline;

  Vec3 spacing() const { return {lengths.x / points[0], lengths.y / points[1], lengths.z / points[2]}; }
  double volume() const { return lengths.x * lengths.y * lengths.z; }
};

/// What makes potentials of charges on a mesh, such that the forces, taken by differentiated splines, are as near as
/// can be to those of clouds (Hockney and Eastwood 1988, 8-22, for such forces).
struct Influence {
  /// For mode (x, y, z) at (y * points[0] + x) * (points[2] / 2 + 1) + z, divided by the volume: what an unnormalized
  /// transform and back needs.
  std::vector<double> factor;
  /// A charge that sits u spacings behind a mesh point along axis k sees, of itself, the potential
  /// sum_n self_wave[k][n - 1] cos(2 pi n u) more than on average: splines are not quite translation invariant.
  std::array<std::array<double, 2>, 3> self_wave{};
};

Influence optimal_influence(const Mesh& mesh, const Cloud& cloud);

/// Integral over space, averaged over the first charge's place on the mesh, of the square of the error of the force
/// between two unit charges, with the optimal influence (Hockney and Eastwood 1988, 8-23). It hardly depends on the
/// size of the box. With dipoles that point anywhere beside the charges, of mean square `dipole2` where that of charges
/// is 1: a wave k of either is q + i k.mu, and counts q^2 + k^2 mu^2 / 3 (README, dipoles on a mesh).
double mesh_error(const Mesh& mesh, const Cloud& cloud, double dipole2 = 0);
/// The same of charges alone, with another window than the mesh's.
double mesh_error(const Mesh& mesh, const Cloud& cloud, const WindowTransform& window);

}  // namespace lichtenberg::periodic
