#pragma once

#include <array>

/// Two conducting spheres in free space, by the series of bispherical coordinates.
namespace lichtenberg::theory {

/// Capacitances over 4 pi eps (m) of two spheres, and their derivatives by the distance of the centres.
struct SphereCapacitances {
  double own_first = 0, mutual = 0, own_second = 0;
  double slope_first = 0, slope_mutual = 0, slope_second = 0;
};

/// Computes the capacitance coefficients of spheres of radii a and b at the distance d of their centres (Smythe, Static
/// and Dynamic Electricity, 5.08). With cosh u = (d^2 - a^2 - b^2) / (2 a b):
///   c11 = a b sinh u sum over n > 0 of 1 / (b sinh(n u) + a sinh((n - 1) u)), c22 with a and b exchanged,
///   c12 = -(a b / d) sinh u sum over n > 0 of 1 / sinh(n u).
/// The derivatives are imaginary parts at a complex distance, without cancellation.
SphereCapacitances sphere_capacitances(double a, double b, double d);

/// Potentials and charges over 4 pi eps of two spheres, and the force over 4 pi eps on the second, positive away from
/// the first.
struct SpherePair {
  std::array<double, 2> potential{}, charge{};
  double force = 0, energy = 0;  ///< Half of the sum of charge times potential, over 4 pi eps
};
/// Computes the state of two spheres, each with a given potential, or with a given charge over 4 pi eps (floating).
SpherePair sphere_pair(const SphereCapacitances& capacitances, std::array<bool, 2> floating,
                       std::array<double, 2> given);

}  // namespace lichtenberg::theory
