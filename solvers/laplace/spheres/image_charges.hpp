#pragma once

#include <array>
#include <vector>

namespace lichtenberg::laplace::spheres {

/// Point charge over 4 pi eps (V m) on a radius of a sphere, at a distance (m) from its centre.
struct AxialCharge {
  double position = 0, charge = 0;
};

/// Exact solution for one of two isolated conducting spheres with equal and opposite charges and a potential difference
/// of 1.
struct PairSolution {
  /// Axial multipoles a_l, l = 0 ... degree (m = 0 about the direction to the other sphere).
  std::vector<double> multipoles;
  std::vector<AxialCharge> charges;  ///< Image charges
  double potential = 0;              ///< Potential of the sphere
};
/// Computes the exact solutions of both spheres of a pair by the method of images. Each image charge is mirrored at the
/// other sphere until it is below `accuracy` times the first one. `radius`, `other`: radii, `gap`: surface distance
/// (m). The first result is that of the sphere of `radius`.
std::array<PairSolution, 2> pair_solution(double radius, double other, double gap, int degree, double accuracy);

/// Replaces charges on a radius of a sphere by fewer charges with the same field outside. Panels of the radius halve
/// towards the surface. A panel of more charges than its 20 Chebyshev points has charges at these points instead. They
/// interpolate the field as a function of the position s. This is analytic in a complex s with |s| < R. Harmonics on
/// another sphere of radius R' outside are then at most those of a charge at the distance R'. Each panel's ellipse of
/// semi-axes of 3 and sqrt(8) half-widths is within that circle. So errors are about (3 + sqrt(8))^-20 = 5e-16 of the
/// largest such field.
std::vector<AxialCharge> condensed(const std::vector<AxialCharge>& charges, double radius);

}  // namespace lichtenberg::laplace::spheres
