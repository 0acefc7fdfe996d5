#include "validation/theory/two_spheres.hpp"

#include <cmath>
#include <complex>

namespace lichtenberg::theory {
namespace {

using Complex = std::complex<long double>;

/// Returns the sum over n > 0 of 1 / (p sinh(n u) + q sinh((n - 1) u)).
Complex inverse_sum(Complex u, Complex p, Complex q) {
  constexpr long double digits = 45;  // exp(-45) is 3e-20
  Complex sum = 0;
  for (int n = 1; n * u.real() < digits; ++n)
    sum += 1.0L / (p * std::sinh(u * static_cast<long double>(n)) + q * std::sinh(u * static_cast<long double>(n - 1)));
  return sum;
}

}  // namespace

SphereCapacitances sphere_capacitances(double a, double b, double d) {
  constexpr long double step = 1e-30L;  // The error of the derivative is its square
  const Complex distance(d, step);
  const long double p = a, q = b;
  // cosh u - 1 without cancellation, for narrow gaps
  const Complex less_one = (distance - p - q) * (distance + p + q) / (2 * p * q);
  const Complex sinh_u = std::sqrt(less_one * (less_one + 2.0L));
  const Complex u = std::log(1.0L + less_one + sinh_u), unit = p * q * sinh_u;
  const Complex first = unit * inverse_sum(u, q, p), second = unit * inverse_sum(u, p, q),
                mutual = -unit / distance * inverse_sum(u, 1, 0);
  const auto value = [](Complex c) { return static_cast<double>(c.real()); };
  const auto slope = [](Complex c) { return static_cast<double>(c.imag() / step); };
  return {value(first), value(mutual), value(second), slope(first), slope(mutual), slope(second)};
}

SpherePair sphere_pair(const SphereCapacitances& c, std::array<bool, 2> floating, std::array<double, 2> given) {
  SpherePair pair;
  auto& [v, w] = pair.potential;
  const auto [x, y] = given;
  v = x, w = y;
  if (floating[0] && floating[1]) {
    const double determinant = c.own_first * c.own_second - c.mutual * c.mutual;
    v = (c.own_second * x - c.mutual * y) / determinant, w = (c.own_first * y - c.mutual * x) / determinant;
  } else if (floating[0]) {
    v = (x - c.mutual * w) / c.own_first;
  } else if (floating[1]) {
    w = (y - c.mutual * v) / c.own_second;
  }
  pair.charge = {c.own_first * v + c.mutual * w, c.mutual * v + c.own_second * w};
  pair.force = 0.5 * (c.slope_first * v * v + 2 * c.slope_mutual * v * w + c.slope_second * w * w);
  pair.energy = 0.5 * (pair.charge[0] * v + pair.charge[1] * w);
  return pair;
}

}  // namespace lichtenberg::theory
