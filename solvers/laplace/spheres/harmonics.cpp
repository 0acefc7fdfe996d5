#include "solvers/laplace/spheres/harmonics.hpp"

#include <array>
#include <cmath>

namespace lichtenberg::laplace::spheres {

namespace {

/// Factors of the recursion of regular_harmonics.
struct Recursion {
  static constexpr int most = 48;  ///< Largest tabulated degree; factors of higher ones are computed when needed
  std::array<double, most + 1> up{};
  std::array<double, harmonics(most)> below{}, over{};  ///< At [at(l, m)], m >= 0

  static double up_of(int l) { return std::sqrt((2 * l - 1) / (2.0 * l)) * (l == 1 ? std::sqrt(2.0) : 1); }
  static double below_of(int l, int m) { return std::sqrt(static_cast<double>(l - 1 - m) * (l - 1 + m)); }
  static double over_of(int l, int m) { return 1 / std::sqrt(double(l - m) * (l + m)); }

  Recursion() {
    for (int l = 1; l <= most; ++l) {
      up[l] = up_of(l);
      for (int m = 0; m < l; ++m) below[at(l, m)] = below_of(l, m), over[at(l, m)] = over_of(l, m);
    }
  }
};

/// Wigner functions d^l_(m', m) (pi/2) for m' = 0 ... l and m = 0 ... l, from those with m' = l (Trapani and Navaza,
/// Acta Cryst. A 62, 262 (2006)): stable up to degrees of thousands.
class HalfTurns {
 public:
  explicit HalfTurns(int degree) : side_(degree + 1), top_(side_), delta_(static_cast<std::size_t>(side_) * side_) {
    top_[0] = 1;
  }
  /// Advances to degree l; to be called with l = 0, 1, 2, ...
  void advance(int l) {
    if (l > 0) advance_top(l);
    for (int m = 0; m <= l; ++m) delta_[index(l, m)] = top_[m];
    for (int m = 0; m <= l; ++m)
      for (int k = l - 1; k >= 0; --k) {
        const double over = std::sqrt(static_cast<double>(l - k) * (l + k + 1));
        const double two_above = k + 2 <= l ? delta_[index(k + 2, m)] : 0;
        delta_[index(k, m)] = 2 * m / over * delta_[index(k + 1, m)] -
                              std::sqrt(static_cast<double>(l - k - 1) * (l + k + 2)) / over * two_above;
      }
  }
  double operator()(int row, int column) const { return delta_[index(row, column)]; }

 private:
  std::size_t index(int row, int column) const { return static_cast<std::size_t>(row) * side_ + column; }
  void advance_top(int l) {
    for (int m = l; m >= 1; --m) top_[m] = std::sqrt(l * (2.0 * l - 1) / (2.0 * (l + m) * (l + m - 1))) * top_[m - 1];
    top_[0] *= -std::sqrt((2.0 * l - 1) / (2.0 * l));
  }

  int side_;
  std::vector<double> top_, delta_;
};

}  // namespace

void regular_harmonics(Vec3 r, int degree, double* value) {
  static const Recursion factors;
  const double r2 = norm2(r);
  value[0] = 1;
  for (int l = 1; l <= degree; ++l) {
    const bool known = l <= Recursion::most;
    // Sectoral harmonics follow from the degree below, times (x + i y).
    const double up = known ? factors.up[l] : Recursion::up_of(l);
    const double cosine = value[at(l - 1, l - 1)], sine = l == 1 ? 0 : value[at(l - 1, 1 - l)];
    value[at(l, l)] = up * (r.x * cosine - r.y * sine);
    value[at(l, -l)] = up * (r.x * sine + r.y * cosine);
    for (int m = 0; m < l; ++m) {
      const double below = known ? factors.below[at(l, m)] : Recursion::below_of(l, m),
                   over = known ? factors.over[at(l, m)] : Recursion::over_of(l, m);
      for (const int k : {m, -m}) {
        const double before = l - 2 >= m ? value[at(l - 2, k)] : 0;
        value[at(l, k)] = over * ((2 * l - 1) * r.z * value[at(l - 1, k)] - below * r2 * before);
        if (m == 0) break;
      }
    }
  }
}

QuarterTurn::QuarterTurn(int degree) : degree_(degree) {
  HalfTurns half(degree);
  for (int l = 0; l <= degree; ++l) {
    half.advance(l);
    for (int m = -l; m <= l; ++m) {
      const bool sine = reads_sines(l, m);
      const int first = first_column(l, m);
      start_.push_back({sine, first, value_.size()});
      const int row = std::abs(m);
      for (int k = first; k <= l; k += 2) {
        // A rotation about y mixes the harmonics by d^l(pi/2). Rotations by pi/2 about z before and after it make it
        // one about x, and leave these signs.
        const double scale = (row == 0 ? 1 : std::sqrt(2.0)) * (k == 0 ? 1 : std::sqrt(2.0));
        const int halves = (m < 0 && !sine ? row - k - 1 : sine && m >= 0 ? k - row - 1 : row - k) / 2;
        value_.push_back((halves & 1 ? -scale : scale) * half(row, k));
      }
    }
  }
}

std::vector<std::complex<double>> to_complex(const double* real, int degree) {
  std::vector<std::complex<double>> result(harmonics(degree));
  const double half = std::sqrt(0.5);
  for (int l = 0; l <= degree; ++l) {
    result[at(l, 0)] = real[at(l, 0)];
    for (int m = 1; m <= l; ++m) {
      const std::complex<double> value{half * real[at(l, m)], half * real[at(l, -m)]};
      result[at(l, -m)] = value;
      result[at(l, m)] = (m & 1 ? -1.0 : 1.0) * std::conj(value);
    }
  }
  return result;
}

}  // namespace lichtenberg::laplace::spheres
