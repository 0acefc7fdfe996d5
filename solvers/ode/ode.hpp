#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lichtenberg {

/// Ordinary differential equations dy/dt = f(t, y) with smooth f.
struct Ode {
  using Value = std::function<double(double t, std::span<const double> y)>;

  std::function<void(double t, std::span<const double> y, std::span<double> rate)> rates;
  std::vector<double> absolute;  ///< Absolute error tolerance of a step for each y, in addition to `relative`
  double relative = 2e-14;       ///< Relative error tolerance of a step
  std::vector<Value> falls{};    ///< Functions of which the first to fall through zero ends the integration
  bool stiff = false;            ///< True if some components decay much faster than the times of interest; many
                                 ///< equations are possible
};

struct OdeEnd {
  double time = 0;
  int event = -1;  ///< Index of the function that fell through zero; -1: none
};

/// Integrates y from `start` to `end` or to the first event, by CVODE (Cohen and Hindmarsh 1996) with formulas of
/// variable order and step. Non-stiff: Adams formulas with fixed-point iteration. Stiff: backward differences with
/// Newton's method, GMRES, and Jacobian products from differences of rates. A stiff step with a rate that is not finite
/// is repeated with a shorter step. Throws Failure if the accuracy cannot be reached, and exceptions of the functions.
OdeEnd integrate(const Ode& ode, double start, double end, std::vector<double>& y);

/// Returns y at each of these times (ascending, >= start), in one integration. CVODE's interpolation between steps
/// keeps the accuracy and all linear invariants. An event ends the integration; the result then contains only the times
/// before it.
std::vector<std::vector<double>> integrate(const Ode& ode, double start, const std::vector<double>& y,
                                           std::span<const double> times);

}  // namespace lichtenberg
