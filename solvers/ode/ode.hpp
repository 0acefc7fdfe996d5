#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lichtenberg {

/// Initial value problem of a system of ordinary differential equations dy/dt = f(t, y) with smooth f, and the options
/// of its integration. The unknowns y and the time t have any units.
struct Ode {
  /// Event function: an event is a time at which its value changes from positive to negative.
  using Value = std::function<double(double t, std::span<const double> y)>;

  /// Writes the right-hand side f(t, y) to `rate`, which has the size of y.
  std::function<void(double t, std::span<const double> y, std::span<double> rate)> rates;
  std::vector<double> absolute;  ///< Absolute error tolerance of a step for each y, in addition to `relative`
  double relative = 2e-14;       ///< Relative error tolerance of a step
  std::vector<Value> falls{};    ///< Event functions; the first event ends the integration
  bool stiff = false;            ///< True if some components decay much faster than the times of interest
  /// Writes the Jacobian matrix of `rates`, df_i/dy_j in element j * size + i, for stiff equations; empty: the matrix
  /// is not formed.
  std::function<void(double t, std::span<const double> y, std::span<double> matrix)> jacobian{};
};

/// End of an integration: its time, and the event that caused it, if any.
struct OdeEnd {
  double time = 0;
  int event = -1;  ///< Index of the event function in Ode::falls that fell through zero; -1: no event occurred
};

/// Integrates ordinary differential equations from time `start` to `end` or to the first event, and overwrites y with
/// the solution there.
/// The library CVODE (Cohen and Hindmarsh 1996) chooses order and step. Non-stiff equations: Adams formulas with
/// fixed-point iteration. Stiff equations: backward differentiation formulas with Newton's method. Its linear
/// equations are solved by LU factorization of the given Jacobian, or else by GMRES with Jacobian products from
/// differences of rates. A stiff step with a rate that is not finite is repeated with a shorter step.
/// Throws Failure if CVODE fails, such as with a tolerance below the rounding error. Passes on exceptions of the
/// functions in `ode`.
OdeEnd integrate(const Ode& ode, double start, double end, std::vector<double>& y);

/// Integrates ordinary differential equations from time `start` with initial values y, and returns the solution at each
/// of `times` (ascending, >= start). Values between the steps follow from CVODE's interpolation polynomial. An event
/// ends the integration; the result then contains only the times before it. Throws Failure if CVODE fails, and passes
/// on exceptions of the functions in `ode`.
std::vector<std::vector<double>> integrate(const Ode& ode, double start, const std::vector<double>& y,
                                           std::span<const double> times);

}  // namespace lichtenberg
