#pragma once

#include <boost/math/quadrature/exp_sinh.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <limits>

namespace lichtenberg {

/// 2 int_0^inf K_0(2w) f(w) dw by quadrature: the mean over the product of two Gaussian charges.
template <class F>
double over_charges(const F& f) {
  static boost::math::quadrature::exp_sinh<double> quadrature;
  return 2 * quadrature.integrate([&](double w) { return w < 300 ? boost::math::cyl_bessel_k(0, 2 * w) * f(w) : 0.0; },
                                  0.0, std::numeric_limits<double>::infinity(), 1e-13);
}

/// h_N and h_T of `src/theory/kinetic.hpp`, by Gamma(p) - Gamma(p, b) without cancellation.
inline double h_number(double b) { return boost::math::tgamma_lower(2, b) + b * boost::math::tgamma_lower(1, b); }
inline double h_energy(double b) { return boost::math::tgamma_lower(3, b) + b * boost::math::tgamma_lower(2, b); }

/// Mean of samples and its standard error.
struct Estimate {
  double sum = 0, squares = 0;
  int count = 0;
  void add(double value) { sum += value, squares += value * value, ++count; }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt((squares / count - mean() * mean()) / count); }
};

}  // namespace lichtenberg
