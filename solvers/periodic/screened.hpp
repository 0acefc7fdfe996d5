#pragma once

#include <cmath>
#include <numbers>

#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Minimum-image convention: reduces a difference of two positions to that of the nearest images in a box with these
/// edges.
inline Vec3 nearest_image(Vec3 r, Vec3 lengths) {
  for (int k = 0; k < 3; ++k) r[k] -= lengths[k] * std::nearbyint(r[k] / lengths[k]);
  return r;
}

/// Values of the real-space Ewald functions B_0 = erfc(alpha r) / r and B_(n+1) = -B_n' / r (Smith 1998). B_0 is the
/// potential of a unit charge screened by an opposite Gaussian cloud; B_1 to B_3 give its derivatives. At alpha = 0
/// they are 1/r, 1/r^3, 3/r^5, 15/r^7.
struct Screened {
  double b0, b1, b2, b3;
};

/// Computes the real-space Ewald functions at the squared distance r2.
inline Screened screened(double r2, double alpha) {
  const double r = std::sqrt(r2), a2 = alpha * alpha, inverse = 1 / r2;
  const double gauss = 2 * alpha * std::numbers::inv_sqrtpi * std::exp(-a2 * r2);
  const double b0 = std::erfc(alpha * r) / r;
  const double b1 = (b0 + gauss) * inverse;
  const double b2 = (3 * b1 + 2 * a2 * gauss) * inverse;
  return {b0, b1, b2, (5 * b2 + 4 * a2 * a2 * gauss) * inverse};
}

/// Computes the functions of screened() at alpha = 0, for the unscreened Coulomb potential.
inline Screened unscreened(double r2) {
  const double inverse = 1 / r2, b0 = std::sqrt(inverse), b1 = b0 * inverse, b2 = 3 * b1 * inverse;
  return {b0, b1, b2, 5 * b2 * inverse};
}

/// Point charge with a point dipole.
struct Multipole {
  double charge = 0;
  Vec3 dipole{};
};

/// Returns charge and dipole (0 without dipoles) of source i.
inline Multipole multipole(const Sources& sources, int i) {
  const std::span<const double> mu = sources.dipole;
  return {sources.charge[i], mu.empty() ? Vec3{} : Vec3{mu[3 * i], mu[3 * i + 1], mu[3 * i + 2]}};
}

/// Potential, field and force at one source.
struct FieldSample {
  double potential = 0;
  Vec3 field{}, force{};
};

/// Computes potential, field and force at the source `on` due to the source `from`, whose position relative to `on` is
/// r; `b`: screened() at |r|. The potential is (from.charge + from.dipole . d/dr) B_0(r). Relative to `from`, `on` is
/// at -r. The field is therefore the gradient of the potential in r, and the force is (on.charge - on.dipole . d/dr)
/// times the field.
inline FieldSample pair_field(const Screened& b, Vec3 r, const Multipole& on, const Multipole& from) {
  const double along_from = dot(from.dipole, r), along_on = dot(on.dipole, r);
  const double radial = from.charge * b.b1 - along_from * b.b2;
  const double slope = from.charge * b.b2 - along_from * b.b3;
  FieldSample result;
  result.potential = from.charge * b.b0 - along_from * b.b1;
  result.field = -radial * r - b.b1 * from.dipole;
  result.force = on.charge * result.field + radial * on.dipole - b.b2 * along_on * from.dipole -
                 (slope * along_on + b.b2 * dot(on.dipole, from.dipole)) * r;
  return result;
}

}  // namespace lichtenberg::periodic
