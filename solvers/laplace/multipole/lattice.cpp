#include "solvers/laplace/multipole/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace lichtenberg::laplace::multipole {

namespace {

using std::numbers::pi;

/// Approximate radius of the circle on which the Taylor series is computed, and radius within which lattice vectors are
/// excluded from it, in units of half the period's diagonal. Their ratio 0.4 makes 40 terms sufficient to rounding
/// (0.4^40 = 1e-16).
constexpr double taylor_radius = 2, near_reach = 5;
constexpr int taylor_terms = 40;
/// Radius beyond which lattice vectors belong to the separate series for points within half the diagonal: 1 / 2.8^40 =
/// 1e-18.
constexpr double inner_reach = 2.8;
constexpr int taylor_points = 4 * taylor_terms;  // Aliasing from order 4 * 40 is 0.4^120

Complex point_on_circle(double radius, int j) { return std::polar(radius, 2 * pi * j / taylor_points); }

/// Computes cot u without overflow far from the real axis.
Complex cotangent(Complex u) {
  if (u.imag() < 0) return std::conj(cotangent(std::conj(u)));
  const Complex e = std::exp(2.0 * i_unit * u);
  return i_unit * (e + 1.0) / (e - 1.0);
}

/// Computes 1 / sin u without overflow far from the real axis.
Complex cosecant(Complex u) {
  if (u.imag() < 0) return std::conj(cosecant(std::conj(u)));
  const Complex e = std::exp(i_unit * u);
  return 2.0 * i_unit * e / (e * e - 1.0);
}

}  // namespace

LatticeSum::LatticeSum(const Mirrors& mirrors) : bounded_(mirrors.bounded) {
  if (!bounded_) {
    near_ = inner_ = {Vector{}};
    inner_series_ = {0};
    return;
  }
  period_ = 2 * mirrors.size;
  sign_x_ = mirrors.period_sign_x();
  sign_y_ = mirrors.period_sign_y();
  // Rows run along the axis with alternating signs, so that each row's field decreases exponentially. If no signs
  // alternate, rows run across a pair of electrodes: adjacent images of opposite sign in a row then cancel its growth.
  const bool alternates_y_only = sign_x_ > 0 && sign_y_ < 0;
  const bool electrodes_y_only = mirrors.side_sign[left] > 0 && mirrors.side_sign[bottom] < 0;
  rows_along_y_ = alternates_y_only || (sign_x_ > 0 && sign_y_ > 0 && electrodes_y_only);
  if (sign_x_ > 0 && sign_y_ > 0) background_ = pi / (period_.x * period_.y);
  const double half_diagonal = 0.5 * norm(period_);
  find_near(near_reach * half_diagonal);
  find_taylor(clear_radius(taylor_radius * half_diagonal));
  find_inner_series();
}

void LatticeSum::find_near(double reach) {
  const int n_most = static_cast<int>(reach / period_.x), m_most = static_cast<int>(reach / period_.y);
  for (int m = -m_most; m <= m_most; ++m)
    for (int n = -n_most; n <= n_most; ++n) {
      const Complex shift{n * period_.x, m * period_.y};
      const double sign = (n % 2 == 0 ? 1 : sign_x_) * (m % 2 == 0 ? 1 : sign_y_);
      if (std::abs(shift) <= reach) near_.push_back({n, m, shift, sign});
    }
  const auto origin = std::find_if(near_.begin(), near_.end(), [](const Vector& v) { return v.n == 0 && v.m == 0; });
  std::iter_swap(near_.begin(), origin);
}

/// Computes d Lambda / dz, row by row. A row of equal signs is ln sin, one of alternating signs ln tan.
Complex LatticeSum::rows_derivative(Complex z) const {
  if (rows_along_y_) z *= -i_unit;
  const double along = rows_along_y_ ? period_.y : period_.x, across = rows_along_y_ ? period_.x : period_.y;
  const int sign_along = rows_along_y_ ? sign_y_ : sign_x_, sign_across = rows_along_y_ ? sign_x_ : sign_y_;
  const auto row = [&](Complex at) { return sign_along > 0 ? cotangent(pi / along * at) : cosecant(pi / along * at); };
  // Further rows contribute exp(-pi (distance from z) / along) < 1e-17.
  const int rows = static_cast<int>(std::ceil((std::abs(z.imag()) + 12.5 * along) / across));
  Complex sum = row(z);
  for (int m = 1; m <= rows; ++m) {
    const Complex shift{0, m * across};
    sum += (m % 2 == 0 ? 1.0 : sign_across) * (row(z - shift) + row(z + shift));
  }
  return (rows_along_y_ ? -i_unit : Complex{1}) * pi / along * sum;
}

/// Returns the real part at the origin of Lambda without its near vectors. The constant is arbitrary if it cancels
/// among the images. If the signs of a row alternate, Lambda is a sum of ln tan, and the constant is determined.
double LatticeSum::constant() const {
  const double along = rows_along_y_ ? period_.y : period_.x, across = rows_along_y_ ? period_.x : period_.y;
  const int sign_along = rows_along_y_ ? sign_y_ : sign_x_, sign_across = rows_along_y_ ? sign_x_ : sign_y_;
  if (sign_along > 0) return 0;
  double sum = std::log(0.5 * pi / along);  // Limit of ln |tan(pi z / 2 along)| - ln |z| at 0
  for (int m = 1; m <= std::ceil(12.5 * along / across); ++m)
    sum += (m % 2 == 0 ? 2.0 : 2.0 * sign_across) * std::log(std::tanh(0.5 * pi * m * across / along));
  for (std::size_t v = 1; v < near_.size(); ++v) sum -= near_[v].sign * std::log(std::abs(near_[v].shift));
  return sum;
}

/// Returns a radius close to the given one on which no sample point is close to a lattice vector, because the poles are
/// subtracted there.
double LatticeSum::clear_radius(double radius) const {
  double best = radius, largest_clearance = 0;
  for (int step = -5; step <= 5; ++step) {
    const double factor = 1 + 0.02 * step;
    double clearance = std::numeric_limits<double>::infinity();
    for (int j = 0; j < taylor_points; ++j)
      for (const Vector& w : near_)
        clearance = std::min(clearance, std::norm(point_on_circle(factor * radius, j) - w.shift));
    if (clearance <= largest_clearance) continue;
    largest_clearance = clearance;
    best = factor * radius;
  }
  return best;
}

/// Computes the Taylor coefficients by Cauchy's integral for the derivative, from equidistant points on a circle.
void LatticeSum::find_taylor(double radius) {
  constexpr int points = taylor_points;
  std::vector<Complex> derivative(points);
  for (int j = 0; j < points; ++j) {
    const Complex z = point_on_circle(radius, j);
    derivative[j] = rows_derivative(z);
    for (const Vector& w : near_) derivative[j] -= w.sign / (z - w.shift);
  }
  taylor_.assign(taylor_terms + 1, 0);
  taylor_[0] = constant();
  for (int n = 0; n < taylor_terms; ++n) {
    Complex sum = 0;
    for (int j = 0; j < points; ++j) sum += derivative[j] * std::polar(1.0, -2 * pi * ((n * j) % points) / points);
    taylor_[n + 1] = sum / (points * std::pow(radius, n) * (n + 1));
  }
}

void LatticeSum::find_inner_series() {
  inner_series_.resize(taylor_terms / 2 + 1);
  for (std::size_t k = 0; k < inner_series_.size(); ++k) inner_series_[k] = taylor_[2 * k].real();
  const double reach = inner_reach * 0.5 * norm(period_);
  for (const Vector& w : near_) {
    if (std::abs(w.shift) < reach) {
      inner_.push_back(w);
      continue;
    }
    // ln |z - w| = ln |w| - Re sum (z/w)^n / n
    inner_series_[0] += w.sign * std::log(std::abs(w.shift));
    for (std::size_t k = 1; k < inner_series_.size(); ++k)
      inner_series_[k] -=
          w.sign * std::pow(w.shift, -2.0 * static_cast<double>(k)).real() / (2.0 * static_cast<double>(k));
  }
}

void LatticeSum::far_derivatives(Complex z, int count, Complex* value) const {
  std::fill(value, value + count, Complex{0});
  if (!bounded_) return;
  // Taylor shift by repeated synthetic division: afterwards c[n] is the n-th Taylor coefficient at z.
  std::array<Complex, taylor_terms + 1> c;
  std::copy(taylor_.begin(), taylor_.end(), c.begin());
  const int shifted = std::min(count, taylor_terms + 1);
  double factorial = 1;
  for (int n = 0; n < shifted; ++n) {
    for (int k = taylor_terms - 1; k >= n; --k) c[k] += multiply(c[k + 1], z);
    value[n] = factorial * c[n];
    factorial *= n + 1;
  }
}

/// Adds -pi (y + dy)^2 / area, or the same for x: for a step t = dx + i dy, y dy = Re(-i y t). The square of the step
/// is not harmonic, and belongs to the part that cancels.
void LatticeSum::add_background(Complex z, Complex* value) const {
  const double across = rows_along_y_ ? z.real() : z.imag();
  value[0] -= background_ * across * across;
  value[1] -= 2 * background_ * across * (rows_along_y_ ? Complex{1} : -i_unit);
}

Complex LatticeSum::reduced(Complex z, double& sign) const {
  sign = 1;
  if (!bounded_) return z;
  const double n = std::round(z.real() / period_.x), m = std::round(z.imag() / period_.y);
  if (sign_x_ < 0 && std::fmod(n, 2) != 0) sign = -sign;
  if (sign_y_ < 0 && std::fmod(m, 2) != 0) sign = -sign;
  return z - Complex{n * period_.x, m * period_.y};
}

double LatticeSum::real_part(Complex z, double least) const {
  double sign = 1;
  z = reduced(z, sign);
  // One logarithm of a product costs less than many logarithms; in units of the period the product cannot overflow.
  const double unit = bounded_ ? 1 / norm2(period_) : 1;
  double numerator = unit * std::max(std::norm(z), least * least), denominator = 1, charge = 1;
  for (std::size_t v = 1; v < inner_.size(); ++v) {
    (inner_[v].sign > 0 ? numerator : denominator) *= unit * std::norm(z - inner_[v].shift);
    charge += inner_[v].sign;
  }
  const Complex square = multiply(z, z);
  Complex series = 0;
  for (std::size_t k = inner_series_.size(); k-- > 0;) series = multiply(series, square) + inner_series_[k];
  std::array<Complex, 2> background{};
  add_background(z, background.data());
  const double sum = 0.5 * (std::log(numerator / denominator) - charge * std::log(unit));
  return sign * (sum + series.real() + background[0].real());
}

}  // namespace lichtenberg::laplace::multipole
