#pragma once

#include <functional>
#include <span>
#include <vector>

namespace lichtenberg {

/// dy/dt = f(t, y), smooth equations.
struct Ode {
  using Value = std::function<double(double t, std::span<const double> y)>;

  std::function<void(double t, std::span<const double> y, std::span<double> rate)> rates;
  std::vector<double> absolute;  ///< error that a step may make in each y, added to
  double relative = 2e-14;       ///< this part of it
  std::vector<Value> falls{};    ///< the first of these to fall through zero ends the integration
  bool stiff = false;            ///< some of it decays much faster than what is looked for; there may be many equations
};

struct OdeEnd {
  double time = 0;
  int event = -1;  ///< which value fell through zero; -1: none did
};

/// Carries y from time `start` to time `end` or to the first event, by CVODE (Cohen and Hindmarsh 1996) in formulas of
/// variable order and step: Adams' with fixed-point iteration, or if stiff backward differences with Newton's, GMRES
/// and products with the Jacobian from differences of rates; a step to where a rate is not finite is then tried
/// shorter. Throws Failure if the accuracy cannot be reached, and what the functions throw.
OdeEnd integrate(const Ode& ode, double start, double end, std::vector<double>& y);

/// y at each of these times (rising, >= start), in one go: between its steps by CVODE's own polynomials, which keep the
/// accuracy and all linear invariants. An event ends it, and only the times before it come back.
std::vector<std::vector<double>> integrate(const Ode& ode, double start, const std::vector<double>& y,
                                           std::span<const double> times);

}  // namespace lichtenberg
