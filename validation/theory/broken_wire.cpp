#include "validation/theory/broken_wire.hpp"

#include <cmath>
#include <numbers>

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Returns ln(4R / gap) + 2 gamma_e.
double proximity(double radius, double gap) { return std::log(4 * radius / gap) + 2 * std::numbers::egamma; }

}  // namespace

double mean_transverse_force(const BrokenWire& wire, int i, double field) {
  const double n = wire.conductors;
  return wire.capacitance * wire.voltage * field / (2 * (n + 1)) * (n + 1 - 2 * i);
}

double close_spheres_capacitance(double radius, double permittivity, double gap) {
  return pi * permittivity * radius * proximity(radius, gap);
}

double close_spheres_attraction(double radius, double permittivity, double gap, double voltage) {
  return pi * permittivity * radius * voltage * voltage / (2 * gap);
}

double tension(const BrokenWire& wire, double gap) {
  const double charge = wire.capacitance * wire.voltage, p = proximity(wire.radius, gap);
  return charge * charge / (4 * pi * wire.permittivity * 2 * wire.radius * gap * p * p);
}

double shape_coefficient(const BrokenWire& wire, double field, double tension) {
  return (wire.conductors + 1) * wire.capacitance * wire.voltage * field / (6 * wire.length * wire.length * tension);
}

double displacement(const BrokenWire& wire, double shape_coefficient, double x) {
  return shape_coefficient * (x - 0.5 * wire.length) * (wire.length - x) * x;
}

double largest_displacement(const BrokenWire& wire, double shape_coefficient) {
  return shape_coefficient * std::pow(wire.length, 3) / (12 * std::numbers::sqrt3);
}

double critical_field(const BrokenWire& wire, double tension, double slope) {
  const double f = std::sqrt(0.5 + std::sqrt(0.25 + 1 / (slope * slope)));
  return 2 * f * tension / (wire.capacitance * wire.voltage);
}

double slope_at_end(const BrokenWire& wire) { return (wire.conductors + 1) / 6.0; }

double largest_shape_coefficient(const BrokenWire& wire, double p) {
  // The left side is largest at B^2 L^5 / (40 whole_gap) = 1 / (2p - 1).
  const double stretch = 1 / (2 * p - 1), b = std::sqrt(40 * wire.whole_gap() * stretch / std::pow(wire.length, 5));
  return b * std::pow(1 + stretch, -p);
}

double printed_critical_field(const BrokenWire& wire) {
  const double n = wire.conductors, p = proximity(wire.radius, wire.mean_gap());
  return 2.002 * wire.voltage / (2 * wire.whole_gap() * (n + 1) * p * p);
}

}  // namespace lichtenberg::theory
