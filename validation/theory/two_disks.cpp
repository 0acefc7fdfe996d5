#include "validation/theory/two_disks.hpp"

#include <cmath>
#include <numbers>

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

struct LineCharges {
  Vec2 positive, negative;
};

/// Returns the positions of the two line charges. Each is the mirror image of the other in both circles. At distances
/// x1 from `positive`'s centre and x2 from `negative`'s, x1 (d - x2) = R1^2 and x2 (d - x1) = R2^2.
LineCharges line_charges(const DiskPair& pair) {
  const Vec2 separation = pair.negative.centre - pair.positive.centre;
  const double d = norm(separation), r1 = pair.positive.radius, r2 = pair.negative.radius;
  // Half their distance is a = sqrt((d+R1+R2)(d-R1-R2)(d+R1-R2)(d-R1+R2)) / 2d, in factors without cancellation.
  const double a = std::sqrt((d + r1 + r2) * (d - r1 - r2) * (d + r1 - r2) * (d - r1 + r2)) / (2 * d);
  const double to_radical_axis = (d * d + r1 * r1 - r2 * r2) / (2 * d);
  // x1 = to_radical_axis - a has cancellation for small disks; the power of the centre gives x1 (to_radical_axis + a) =
  // R1^2.
  const double x1 = r1 * r1 / (to_radical_axis + a);
  const double x2 = r2 * r2 / (d - to_radical_axis + a);
  const Vec2 axis = separation / d;
  return {pair.positive.centre + x1 * axis, pair.negative.centre - x2 * axis};
}

double outer_potential(const DiskPair& pair, double charge, Vec2 p) {
  const LineCharges lines = line_charges(pair);
  return charge / (2 * pi * pair.permittivity) * std::log(norm(p - lines.negative) / norm(p - lines.positive));
}

/// Returns the point of `disk` that is farthest from `other`, and thus far from both line charges even at a small gap.
Vec2 far_point(const Disk& disk, const Disk& other) {
  const Vec2 away = disk.centre - other.centre;
  return disk.centre + disk.radius / norm(away) * away;
}

}  // namespace

double capacitance(const DiskPair& pair) {
  const double d = norm(pair.negative.centre - pair.positive.centre);
  const double r1 = pair.positive.radius, r2 = pair.negative.radius;
  // acosh(x) = 2 asinh(sqrt((x - 1) / 2)), and x - 1 = (d - R1 - R2)(d + R1 + R2) / (2 R1 R2): exact at small gaps.
  const double half_angle = std::asinh(std::sqrt((d - r1 - r2) * (d + r1 + r2) / (4 * r1 * r2)));
  return pi * pair.permittivity / half_angle;
}

double positive_potential(const DiskPair& pair, double charge) {
  return outer_potential(pair, charge, far_point(pair.positive, pair.negative));
}

double negative_potential(const DiskPair& pair, double charge) {
  return outer_potential(pair, charge, far_point(pair.negative, pair.positive));
}

double potential(const DiskPair& pair, double charge, Vec2 p) {
  if (signed_distance(pair.positive, p) <= 0) return positive_potential(pair, charge);
  if (signed_distance(pair.negative, p) <= 0) return negative_potential(pair, charge);
  return outer_potential(pair, charge, p);
}

Vec2 force(const DiskPair& pair, double charge) {
  const LineCharges lines = line_charges(pair);
  const Vec2 separation = lines.negative - lines.positive;
  return charge * charge / (2 * pi * pair.permittivity * norm2(separation)) * separation;
}

double error_decay_rate(double eta, double capacitance) { return -2 * std::log(std::abs(1 - eta * capacitance)); }

double small_step_decay_rate(double eta, double capacitance) { return 2 * eta * capacitance; }

}  // namespace lichtenberg::theory
