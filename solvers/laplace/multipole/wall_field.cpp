#include "solvers/laplace/multipole/wall_field.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace lichtenberg::laplace::multipole {

namespace {

using std::numbers::pi;

}  // namespace

WallField::WallField(const Mirrors& mirrors, const LatticeSum& lattice, const std::array<Side, 4>& sides)
    : mirrors_(&mirrors), lattice_(&lattice) {
  if (!mirrors.grounded()) return;
  find_corners(sides);
  find_linear(sides);
}

void WallField::find_corners(const std::array<Side, 4>& sides) {
  const double x = mirrors_->size.x, y = mirrors_->size.y;
  for (const Corner& corner : {Corner{{0, 0}, 0, bottom, left}, Corner{{x, 0}, 0, right, bottom},
                               Corner{{x, y}, 0, top, right}, Corner{{0, y}, 0, left, top}}) {
    if (mirrors_->side_sign[corner.before] > 0 || mirrors_->side_sign[corner.after] > 0) continue;
    const double difference = sides[corner.after].potential - sides[corner.before].potential;
    if (difference != 0) corners_.push_back({corner.at, 2 / pi * difference, corner.before, corner.after});
  }
}

void WallField::find_linear(const std::array<Side, 4>& sides) {
  const auto& sign = mirrors_->side_sign;
  const double x = mirrors_->size.x, y = mirrors_->size.y;
  const std::array<Complex, 4> middle{Complex{0, y / 2}, {x, y / 2}, {x / 2, 0}, {x / 2, y}};
  if (sign[bottom] > 0 && sign[top] > 0 && sign[left] < 0 && sign[right] < 0) {
    slope_ = (sides[right].potential - sides[left].potential) / x;
  } else if (sign[left] > 0 && sign[right] > 0 && sign[bottom] < 0 && sign[top] < 0) {
    slope_ = -i_unit * (sides[top].potential - sides[bottom].potential) / y;
  } else {
    // The field component along an electrode, and that across an insulating side, is zero.
    const auto field_at = [&](SideIndex side) {
      std::array<Complex, 2> value;
      local(middle[side], 1, 2, value.data());
      return value[1];
    };
    const SideIndex no_x = sign[bottom] < 0 ? bottom : sign[top] < 0 ? top : sign[left] > 0 ? left : right;
    const SideIndex no_y = sign[left] < 0 ? left : sign[right] < 0 ? right : sign[bottom] > 0 ? bottom : top;
    slope_ = -Complex{field_at(no_x).real(), field_at(no_y).imag()};
  }
  for (const SideIndex side : {left, right, bottom, top})
    if (sign[side] < 0) {
      constant_ += sides[side].potential - potential(middle[side]);
      break;
    }
}

/// Returns Lambda(z - corner) with arguments that are continuous in the box: each is relative to the middle of the box.
Complex WallField::logarithm(Complex z, Complex corner) const {
  Complex sum = 0;
  lattice_->far_derivatives(z - corner, 1, &sum);
  const Complex middle = 0.5 * to_complex(mirrors_->size);
  for (const LatticeSum::Vector& w : lattice_->near()) {
    const Complex from_corner = z - corner - w.shift, reference = middle - corner - w.shift;
    sum += w.sign * Complex{std::log(std::abs(from_corner)), std::arg(from_corner / reference)};
  }
  return sum;
}

double WallField::potential(Complex z) const {
  double sum = constant_ + (slope_ * z).real();
  for (const Corner& corner : corners_) sum += corner.strength * logarithm(z, corner.at).imag();
  return sum;
}

void WallField::local(Complex z, double radius, int count, Complex* value) const {
  std::fill(value, value + count, Complex{0});
  std::vector<Complex> derivative(count);
  for (const Corner& corner : corners_) {
    lattice_->far_derivatives(z - corner.at, count, derivative.data());
    const Complex strength = -i_unit * corner.strength;
    double scale = 1;  // radius^n / n!
    for (int n = 1; n < count; ++n) {
      scale *= radius / n;
      value[n] += strength * scale * derivative[n];
    }
    for (const LatticeSum::Vector& w : lattice_->near()) {
      const Complex ratio = -radius / (z - corner.at - w.shift);
      Complex power = 1;
      for (int n = 1; n < count; ++n) {
        power = multiply(power, ratio);
        value[n] -= w.sign / n * multiply(strength, power);
      }
    }
  }
  if (count > 1) value[1] += slope_ * radius;
  value[0] = potential(z);
}

double WallField::side_flux(SideIndex side) const {
  const double x = mirrors_->size.x, y = mirrors_->size.y;
  double divergence = 0;
  for (const Corner& corner : corners_)
    if (corner.before == side || corner.after == side)
      divergence += std::copysign(std::numeric_limits<double>::infinity(),
                                  corner.before == side ? -corner.strength : corner.strength);
  if (divergence != 0) return divergence;
  // The stream function Im W increases by the flux to the left of the path: -dV/dn along the side, with the box to its
  // left.
  const auto stream = [&](Complex z) {
    double sum = (slope_ * z).imag();
    for (const Corner& corner : corners_) sum -= corner.strength * logarithm(z, corner.at).real();
    return sum;
  };
  switch (side) {
    case left:
      return stream({0, 0}) - stream({0, y});
    case right:
      return stream({x, y}) - stream({x, 0});
    case bottom:
      return stream({x, 0}) - stream({0, 0});
    default:
      return stream({0, y}) - stream({x, y});
  }
}

}  // namespace lichtenberg::laplace::multipole
