#pragma once

#include <array>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/window.hpp"

namespace lichtenberg::periodic {

/// Axes of a box along which charges have no periodic images. The box is longer than the range of the charges along
/// these axes, and the Green's function 1/r of the mesh ends at the distance `range` in the open directions. All pairs
/// of charges are nearer than that, and all periodic images are farther (Vico, Greengard and Ferrando 2016, J. Comput.
/// Phys. 323, 191; for one and two periodic axes Shamshirgar, Bagge and Tornberg 2021, J. Chem. Phys. 154, 164109).
struct OpenAxes {
  std::array<bool, 3> along{};
  double range = 0;  ///< Distance at which the Green's function ends (length)
  /// Volume of the part of the box that contains charges, also without open axes; 0: the whole box
  double volume = 0;

  bool any() const { return along[0] || along[1] || along[2]; }
};

/// Computes the Fourier transform of the Green's function 1/r that ends at the range of open axes; 4 pi / k^2 without
/// open axes. At k = 0, with all axes periodic, it is 0.
/// The mean over the periodic axes is the potential of a plane or of a line: -2 pi |z| times the charge per area, or -2
/// log(distance) times the charge per length.
double green_transform(Vec3 k, const OpenAxes& open);

/// Mesh in a periodic box, with the window (charge assignment function) by which charges are spread on it.
struct Mesh {
  Vec3 lengths;                    ///< Edges of the box
  std::array<int, 3> points{};     ///< Numbers of points along the axes
  int order = 0;                   ///< Order of the window: number of points along an axis that a charge is spread on
  Window window = Window::spline;  ///< Kind of window
  OpenAxes open{};                 ///< Axes without periodic images, if any

  Vec3 spacing() const { return {lengths.x / points[0], lengths.y / points[1], lengths.z / points[2]}; }  ///< Spacings
  double volume() const { return lengths.x * lengths.y * lengths.z; }  ///< Volume of the box
};

/// Optimal influence function of a particle mesh: the Green's function in Fourier space that maps charges on the mesh
/// to potentials. It minimizes the error of the forces, which are derivatives of the interpolation, relative to the
/// forces of the clouds (Hockney and Eastwood 1988, eq. 8-22).
struct Influence {
  /// Factor of mode (x, y, z), at the index (y * points[0] + x) * (points[2] / 2 + 1) + z. It is divided by the volume,
  /// which normalizes an unnormalized transform and its inverse.
  std::vector<double> factor;
  /// Amplitudes of the self potential's variation on the mesh, because windows are not quite translation invariant. The
  /// potential of a unit charge's own cloud, u spacings behind a mesh point along axis k, exceeds its average by sum_n
  /// self_wave[k][n - 1] cos(2 pi n u).
  std::array<std::array<double, 2>, 3> self_wave{};
};

/// Computes the optimal influence function of a mesh and a charge cloud.
Influence optimal_influence(const Mesh& mesh, const Cloud& cloud);

/// Computes the squared error of the force between two unit charges due to the mesh, with the optimal influence
/// function (Hockney and Eastwood 1988, eq. 8-23). It is integrated over space and averaged over the first charge's
/// position on the mesh, and hardly depends on the size of the box.
/// `dipole2`: mean square of randomly oriented dipoles, in addition to charges of mean square 1. A wave k of a source
/// is q + i k.mu, and counts q^2 + k^2 mu^2 / 3 (docs/numerics/ewald.md).
double mesh_error(const Mesh& mesh, const Cloud& cloud, double dipole2 = 0);
/// Computes mesh_error(mesh, cloud), the squared error of the force due to the mesh, for the given `window` in place of
/// that of `mesh`.
double mesh_error(const Mesh& mesh, const Cloud& cloud, const WindowTransform& window);

}  // namespace lichtenberg::periodic
