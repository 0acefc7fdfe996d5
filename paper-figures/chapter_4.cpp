// Writes theoretical results for D's chapter 4 (src/theory) as JSON, for figures 4.3 and 4.6 to 4.8.

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "validation/theory/broken_wire.hpp"
#include "validation/theory/disk_between_plates.hpp"
#include "validation/theory/shuttle.hpp"

using namespace lichtenberg::theory;

namespace {

constexpr double radius = 0.775e-3, permittivity = 4.7 * 8.8541878128e-12, depth = 2 * radius, voltage = 18e3;
const double drag = 6 * std::numbers::pi * 0.7 * radius;

/// Resistances (Ohm) of a disk between plates, without and with dominant inertia. Contacts close at 0.01 radius.
struct Plane {
  double overdamped, ballistic;
};
Plane plane_resistance(double gap) {
  const DiskBetweenPlates disk = {radius, gap + 2 * radius, voltage, permittivity};
  const double end = disk.position_at_gap(0.01 * radius), charge = at_potential(disk, -end, 0.5 * voltage).charge;
  const auto force = [&](double x) { return depth * with_charge(disk, x, charge).force; };
  const double per_time = voltage / (charge * depth);
  return {overdamped_time(force, drag, -end, end) * per_time, ballistic_time(force, drag, -end, end) * per_time};
}

void print_shuttle() {
  fmt::print("\"shuttle\": [");
  for (int k = 0; k <= 12; ++k) {
    const double gap = 1e-3 * std::pow(20, k / 12.0);
    const SphereShuttle sphere = {radius,       gap,  voltage,
                                  permittivity, drag, isolated_sphere_capacitance(radius, permittivity)};
    const auto [overdamped, ballistic] = plane_resistance(gap);
    fmt::print("{}\n {{\"gap\": {}, \"plane\": {}, \"plane_ballistic\": {}, \"spheres\": {}}}", k ? "," : "", gap,
               overdamped, ballistic, resistance(sphere));
  }
  fmt::print("],\n");
}

void print_wire() {
  const BrokenWire wire = {25, radius, 40e-3, voltage, permittivity, isolated_sphere_capacitance(radius, permittivity)};
  const double at_mean_gap = tension(wire, wire.mean_gap()), at_whole_gap = tension(wire, wire.whole_gap());
  fmt::print("\"wire\": {{\n");
  fmt::print(" \"printed_critical_field\": {},\n", printed_critical_field(wire));
  fmt::print(" \"critical_field_mean_gap\": {},\n", critical_field(wire, at_mean_gap, slope_at_end(wire)));
  fmt::print(" \"critical_field_whole_gap\": {},\n", critical_field(wire, at_whole_gap, slope_at_end(wire)));
  fmt::print(" \"critical_field_whole_gap_shared\": {},\n",
             critical_field(wire, at_whole_gap / 26, slope_at_end(wire)));
  fmt::print(" \"largest_shape_coefficient_disks\": {},\n", largest_shape_coefficient(wire, 1.5));
  // Largest displacement per volt of transverse voltage across 20 mm.
  const auto largest = [&](double tension_force) {
    return largest_displacement(wire, shape_coefficient(wire, 1 / 20e-3, tension_force));
  };
  fmt::print(" \"largest_mean_gap\": {},\n", largest(at_mean_gap));
  fmt::print(" \"largest_whole_gap\": {},\n", largest(at_whole_gap));
  fmt::print(" \"largest_whole_gap_shared\": {}}}\n", largest(at_whole_gap / 26));
}

}  // namespace

int main() {
  fmt::print("{{\n");
  print_shuttle();
  print_wire();
  fmt::print("}}\n");
}
