#include "validation/theory/shuttle.hpp"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <numbers>

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Returns the integral. Intervals are bisected at most ten times, until their Gauss-Kronrod estimates agree to 1e-5 of
/// the whole, because forces have singularities at a contact gap beyond the ends.
double integral(const std::function<double(double)>& f, double from, double to) {
  return boost::math::quadrature::gauss_kronrod<double, 31>::integrate(f, from, to, 10, 1e-5);
}

}  // namespace

double isolated_sphere_capacitance(double radius, double permittivity) { return 4 * pi * permittivity * radius; }

double monopole_force(const SphereShuttle& shuttle, double x) {
  const double a = shuttle.gap + 4 * shuttle.radius, charge = shuttle.capacitance * shuttle.voltage;
  const double difference = a * a - 4 * x * x;
  return 2 * charge * charge / (4 * pi * shuttle.permittivity) * (a * a + 4 * x * x) / (difference * difference);
}

double crossing_time(const SphereShuttle& shuttle) {
  const double g = shuttle.gap, r = shuttle.radius, a = g + 4 * r, c = shuttle.capacitance;
  const double c_over_a =
      4 * pi * shuttle.permittivity * shuttle.drag / (2 * c * c * shuttle.voltage * shuttle.voltage);
  return 4 * c_over_a * (a * a * a * std::atan(g / a) - 2.0 / 3.0 * g * (g + 3 * r) * (g + 6 * r));
}

double mean_current(const SphereShuttle& shuttle) {
  return shuttle.capacitance * shuttle.voltage / (2 * crossing_time(shuttle));
}

double resistance(const SphereShuttle& shuttle) { return shuttle.voltage / mean_current(shuttle); }

double sphere_on_plate_charge(double radius, double permittivity, double field) {
  return 2.0 / 3.0 * pi * pi * pi * permittivity * radius * radius * field;
}

double overdamped_time(const std::function<double(double)>& force, double drag, double from, double to) {
  return drag * integral([&](double x) { return 1 / force(x); }, from, to);
}

double ballistic_time(const std::function<double(double)>& force, double drag, double from, double to) {
  return drag * (to - from) * (to - from) / integral(force, from, to);
}

}  // namespace lichtenberg::theory
