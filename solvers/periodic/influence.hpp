#pragma once

#include <array>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/window.hpp"

namespace lichtenberg::periodic {

/// Mesh in a periodic box, with the window by which charges are spread on it.
struct Mesh {
  Vec3 lengths;  ///< Lengths of the box
  std::array<int, 3> points{};
  int order = 0;
  Window window = Window::spline;

  Vec3 spacing() const { return {lengths.x / points[0], lengths.y / points[1], lengths.z / points[2]}; }
  double volume() const { return lengths.x * lengths.y * lengths.z; }
};

/// Influence function: maps charges on a mesh to potentials. It minimizes the error of the forces, taken by
/// differentiated splines, relative to those of the clouds (Hockney and Eastwood 1988, 8-22).
struct Influence {
  /// Factor of mode (x, y, z), at (y * points[0] + x) * (points[2] / 2 + 1) + z, divided by the volume. This normalizes
  /// an unnormalized transform and its inverse.
  std::vector<double> factor;
  /// Amplitudes of the self potential's variation on the mesh: splines are not quite translation invariant. A unit
  /// charge u spacings behind a mesh point along axis k sees sum_n self_wave[k][n - 1] cos(2 pi n u) more than the
  /// average potential of its own cloud.
  std::array<std::array<double, 2>, 3> self_wave{};
};

Influence optimal_influence(const Mesh& mesh, const Cloud& cloud);

/// Squared error of the force between two unit charges with the optimal influence function (Hockney and Eastwood 1988,
/// 8-23). It is integrated over space and averaged over the first charge's position on the mesh. It hardly depends on
/// the size of the box. `dipole2`: mean square of randomly oriented dipoles, in addition to charges of mean square 1. A
/// wave k of a source is q + i k.mu, and counts q^2 + k^2 mu^2 / 3 (docs/numerics/ewald.md).
double mesh_error(const Mesh& mesh, const Cloud& cloud, double dipole2 = 0);
/// Like mesh_error above, for charges without dipoles and with another window than the mesh's.
double mesh_error(const Mesh& mesh, const Cloud& cloud, const WindowTransform& window);

}  // namespace lichtenberg::periodic
