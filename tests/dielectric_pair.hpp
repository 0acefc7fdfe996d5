#pragma once

#include <cmath>
#include <numbers>
#include <vector>

namespace lichtenberg {

/// Two dielectric spheres of radius 1 and relative permittivity k with uniform charges 1 and -1, eps = 1, in
/// bispherical coordinates (the first with eta > 0). The potential is V = sqrt(cosh eta - mu) sum F_n P_n(mu) f_n(eta),
/// with f_n = sinh((n + 1/2) eta) / sinh((n + 1/2) eta_0) outside and exp((n + 1/2) (eta_0 - eta)) inside. The jump of
/// the flux by the charge,
///   sigma c / sqrt(cosh eta_0 - mu) = sinh(eta_0) (1 - k)/2 sum F_n P_n + (cosh eta_0 - mu) sum (n + 1/2) (coth + k)
///   F_n P_n,
/// gives a three-term recurrence in F by mu P_n = ((n+1) P_(n+1) + n P_(n-1)) / (2n+1).
struct BisphericalPair {
  double potential = 0;   ///< Mean over the first sphere.
  double attraction = 0;  ///< By Maxwell's stress on the middle plane.
};

/// Coefficients F_n for |eta| = `eta` at the spheres. Equal charges 1 and 1 (`like`) have cosh in place of sinh in f_n,
/// and tanh in place of coth.
inline std::vector<double> bispherical_coefficients(double k, double eta, int terms, bool like) {
  const double c = std::sinh(eta), sigma = 1 / (4 * std::numbers::pi);
  const auto slope = [&](int n) {
    const double tangent = std::tanh((n + 0.5) * eta);
    return (n + 0.5) * ((like ? tangent : 1 / tangent) + k);
  };
  std::vector<double> lower(terms), diagonal(terms), upper(terms), f(terms);
  for (int n = 0; n < terms; ++n) {
    diagonal[n] = 0.5 * c * (1 - k) + std::cosh(eta) * slope(n);
    if (n > 0) lower[n] = -slope(n - 1) * n / (2 * n - 1.0);
    if (n + 1 < terms) upper[n] = -slope(n + 1) * (n + 1) / (2 * n + 3.0);
    f[n] = sigma * c * std::sqrt(2.0) * std::exp(-(n + 0.5) * eta);
  }
  for (int n = 1; n < terms; ++n) {
    const double factor = lower[n] / diagonal[n - 1];
    diagonal[n] -= factor * upper[n - 1];
    f[n] -= factor * f[n - 1];
  }
  f[terms - 1] /= diagonal[terms - 1];
  for (int n = terms - 2; n >= 0; --n) f[n] = (f[n] - upper[n] * f[n + 1]) / diagonal[n];
  return f;
}

inline int bispherical_terms(double gap) { return 60 + static_cast<int>(40 / std::sqrt(gap)); }

/// Repulsion of the spheres with charges 1 and 1, by Maxwell's stress on the middle plane, pi times the integral of (1
/// + mu) ((1 - mu) S' - S / 2)^2 over mu, with S = sum F_n P_n / cosh((n + 1/2) eta_0). The integral is a midpoint sum
/// over the angle.
inline double like_charge_repulsion(double k, double gap) {
  const int terms = bispherical_terms(gap);
  const double eta = std::acosh(1 + gap / 2);
  const std::vector<double> f = bispherical_coefficients(k, eta, terms, true);
  const int points = 40 * terms;
  double repulsion = 0;
  for (int point = 0; point < points; ++point) {
    const double angle = std::numbers::pi * (point + 0.5) / points, mu = std::cos(angle);
    double before = 0, legendre = 1, slope = 0, slope_before = 0, s = 0, ds = 0;
    for (int n = 0; n < terms; ++n) {
      const double field = f[n] / std::cosh((n + 0.5) * eta);
      s += field * legendre, ds += field * slope;
      const double next = ((2 * n + 1) * mu * legendre - n * before) / (n + 1);
      const double next_slope = slope_before + (2 * n + 1) * legendre;  // of P_(n+1)
      slope_before = slope, slope = next_slope, before = legendre, legendre = next;
    }
    repulsion += std::sin(angle) * (1 + mu) * std::pow((1 - mu) * ds - s / 2, 2);
  }
  return std::numbers::pi * repulsion * std::numbers::pi / points;
}

inline BisphericalPair dielectric_pair(double k, double gap) {
  const int terms = bispherical_terms(gap);
  const double eta = std::acosh(1 + gap / 2), c = std::sinh(eta);
  const std::vector<double> f = bispherical_coefficients(k, eta, terms, false);
  BisphericalPair pair;
  // Mean over the sphere: dA = 2 pi c^2 dmu / (cosh eta - mu)^2, and sqrt(cosh eta - mu)^-3 is 2 sqrt(2) / sinh(eta)
  // sum (n + 1/2) exp(-(n + 1/2) eta) P_n.
  for (int n = 0; n < terms; ++n)
    pair.potential += 0.5 * c * c * f[n] * 2 * std::sqrt(2.0) / c * std::exp(-(n + 0.5) * eta);
  std::vector<double> field(terms);
  for (int n = 0; n < terms; ++n) field[n] = (n + 0.5) * f[n] / std::sinh((n + 0.5) * eta);
  for (int n = 0; n + 1 < terms; ++n)
    pair.attraction += std::numbers::pi * (field[n] * field[n] * 2 / (2 * n + 1) -
                                           4.0 * (n + 1) / ((2 * n + 1.0) * (2 * n + 3)) * field[n] * field[n + 1]);
  return pair;
}

}  // namespace lichtenberg
