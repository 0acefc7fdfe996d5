#include "solvers/laplace/spheres/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/stop.hpp"

namespace lichtenberg::laplace::spheres {

void irregular_harmonics(Vec3 r, int degree, double* value) {
  regular_harmonics(r, degree, value);
  const double r2 = norm2(r);
  double factor = 1 / std::sqrt(r2);
  for (int l = 0; l <= degree; ++l, factor /= r2)
    for (int m = -l; m <= l; ++m) value[at(l, m)] *= factor;
}

namespace {

using Complex = std::complex<double>;

/// Returns the factor of the expansion of C_lm / r^(l+1) about a point a in regular harmonics of r - a: I_lm(a + b) =
/// sum_tn (-1)^(t+n) sqrt(C(l+t+m-n, l+m) C(l+t-m+n, l-m)) I_(l+t),(m-n)(a) R_tn(b). Harmonics are complex, with the
/// Condon-Shortley phase.
double coupling_factor(int l, int m, int t, int n) {
  const auto log_binomial = [](int a, int b) {
    return std::lgamma(a + 1) - std::lgamma(b + 1) - std::lgamma(a - b + 1);
  };
  const double size = 0.5 * (log_binomial(l + t + m - n, l + m) + log_binomial(l + t - m + n, l - m));
  return ((t + n) & 1 ? -1 : 1) * std::exp(size);
}

/// Returns the coefficients of complex harmonics m and -m in a real harmonic.
std::array<Complex, 2> complex_coefficients(int m) {
  const double half = std::sqrt(0.5);
  const Complex minus = m == 0 ? Complex{0.5} : m > 0 ? Complex{half} : Complex{0, half};
  const Complex plus = m == 0 ? minus : (m & 1 ? -1.0 : 1.0) * std::conj(minus);
  return {plus, minus};
}

}  // namespace

Coupling::Coupling(int degree) : degree_(degree), terms_((degree + 1) * (degree + 1)) {
  for (int l = 0; l <= degree; ++l) {
    stop_if_requested();
    for (int t = 0; l + t <= degree; ++t) {
      std::vector<Term>& terms = terms_[l * (degree + 1) + t];
      for (int n = -t; n <= t; ++n)
        for (int m = -l; m <= l; ++m)
          for (const int k : {std::abs(std::abs(m) - std::abs(n)), std::abs(m) + std::abs(n)}) {
            if (k > l + t) continue;
            for (const int derivative : {k, -k}) {
              // The real derivative k contributes to the complex ones of k and -k like its harmonic.
              Complex sum = 0;
              const auto source = complex_coefficients(m), target = complex_coefficients(n);
              for (const int sm : {1, -1})
                for (const int sn : {1, -1}) {
                  const int cm = sm * std::abs(m), cn = sn * std::abs(n);
                  if (std::abs(cm - cn) != k) continue;
                  // The coefficients in the complex harmonics are the conjugates of those of the real harmonic.
                  const auto value = complex_coefficients(derivative);
                  const Complex v = k == 0 ? Complex{1} : std::conj(cm - cn > 0 ? value[0] : value[1]);
                  sum += source[sm > 0 ? 0 : 1] * coupling_factor(l, cm, t, cn) * v * std::conj(target[sn > 0 ? 0 : 1]);
                }
              if (std::abs(sum.real()) > 1e-14)
                terms.push_back({at(t, n), at(l, m), at(l + t, derivative), sum.real()});
              if (derivative == 0) break;
            }
            if (m == 0 || n == 0) break;
          }
    }
  }
}

template <class T>
void Coupling::add(const double* derivatives, const Source& source, const T* multipoles, const Target& target,
                   T* local) const {
  double source_power = source.sign * source.radius;
  for (int l = 0; l <= std::min(source.degree, degree_); ++l, source_power *= source.radius) {
    double power = source_power;
    for (int t = 0; t <= target.degree && l + t <= degree_; ++t, power *= target.radius)
      for (const Term& term : terms_[l * (degree_ + 1) + t]) {
        const int m = term.source - l * (l + 1);
        local[term.target] += power * term.factor * derivatives[term.derivative] * multipoles[term.source] *
                              static_cast<double>(source.mask ? mirror_sign(l, m, source.mask) : 1);
      }
  }
}

template void Coupling::add(const double*, const Source&, const double*, const Target&, double*) const;
template void Coupling::add(const double*, const Source&, const Lanes*, const Target&, Lanes*) const;

EwaldSplit ewald_split(double range, double accuracy) {
  const double decay = std::sqrt(-std::log(accuracy)) + 0.5, alpha = decay / range;
  return {.alpha = alpha, .cutoff = 1.3 * range, .largest_wave = 2 * alpha * (decay + 1)};
}

EwaldSplit ewald_split_of_all(double cutoff, double accuracy) {
  const double decay = std::sqrt(-std::log(accuracy)) + 0.5, alpha = decay / cutoff;
  return {.alpha = alpha, .cutoff = cutoff, .largest_wave = 2 * alpha * decay};
}

LatticeSum::LatticeSum(const Mirrors& mirrors, double range, int degree, const EwaldSplit& split)
    : mirrors_(mirrors), range_(range), split_(split), degree_(degree) {
  make_waves();
}

void LatticeSum::make_waves() {
  const double most = split_.largest_wave;
  const Vec3 period = mirrors_.period;
  std::array<int, 3> high;
  std::array<double, 3> unit;
  double copies = 1;
  for (int k = 0; k < 3; ++k) {
    unit[k] = 2 * std::numbers::pi / period[k];
    high[k] = static_cast<int>(most / unit[k]);
    if (mirrors_.alternates[k]) copies *= 2;
  }
  const auto is_included = [&](int k, int n) { return !mirrors_.alternates[k] || (n & 1) != 0; };
  for (int x = 0; x <= high[0]; ++x)
    for (int y = x == 0 ? 0 : -high[1]; y <= high[1]; ++y)
      for (int z = x == 0 && y == 0 ? 1 : -high[2]; z <= high[2]; ++z) {
        const Vec3 wave{x * unit[0], y * unit[1], z * unit[2]};
        if (is_included(0, x) && is_included(1, y) && is_included(2, z) && norm2(wave) <= most * most)
          wave_.push_back(wave);
      }
  for (int l = 0; l <= degree_; ++l)
    for (int m = -l; m <= l; ++m) (l & 1 ? odd_at_ : even_at_).push_back(at(l, m));
  even_.resize(even_at_.size(), wave_.size());
  odd_.resize(odd_at_.size(), wave_.size());
  std::vector<double> value(harmonics(degree_));
  for (std::size_t w = 0; w < wave_.size(); ++w) {
    const double k2 = norm2(wave_[w]);
    regular_harmonics(wave_[w], degree_, value.data());
    // Factor 2 for the opposite wave; the sign combines i^l of the derivatives and (-1)^l of their definition.
    double factor =
        2 * copies * 4 * std::numbers::pi / mirrors_.volume() / k2 * std::exp(-k2 / (4 * split_.alpha * split_.alpha));
    int even = 0, odd = 0;
    for (int l = 0; l <= degree_; ++l) {
      if (l > 0) factor /= 2 * l - 1;
      const double sign = l / 2 % 2 == 1 ? -1 : 1;
      for (int m = -l; m <= l; ++m) {
        if (l & 1)
          odd_(odd++, w) = sign * factor * value[at(l, m)];
        else
          even_(even++, w) = sign * factor * value[at(l, m)];
      }
    }
  }
}

void add_screened(Vec3 r, const Screened& screened, int degree, double* term, double* value) {
  const auto [alpha, without, sign] = screened;
  const double t = alpha * alpha * norm2(r);
  if (t < 1e-12) {  // The charge itself: potential of its cloud at the centre
    value[0] -= sign * 2 * alpha / std::sqrt(std::numbers::pi);
    return;
  }
  irregular_harmonics(r, degree, term);
  // Upward recursion of Q(l + 1/2, t): Q(a + 1, t) = Q(a, t) + t^a exp(-t) / Gamma(a + 1).
  double upper = std::erfc(std::sqrt(t)), step = std::exp(-t) * std::sqrt(t / std::numbers::pi) * 2;
  for (int l = 0; l <= degree; ++l) {
    const double factor = sign * (without ? upper - 1 : upper);
    for (int m = -l; m <= l; ++m) value[at(l, m)] += factor * term[at(l, m)];
    upper += step;
    step *= t / (l + 1.5);
  }
}

void LatticeSum::add_near(int mask, Vec3 from, Vec3 position, double* value) const {
  std::vector<double> term(harmonics(degree_));
  for (const MirrorImage& image : mirrors_.images) {
    if (image.mask != mask) continue;
    mirrors_.for_each_copy(position, from + image.shift, split_.cutoff, [&](Vec3 r) {
      add_screened(r, {split_.alpha, norm2(r) < range_ * range_, image.sign}, degree_, term.data(), value);
    });
  }
}

Eigen::MatrixXd LatticeSum::far_derivatives(int mask, const std::vector<Vec3>& from,
                                            const std::vector<Vec3>& positions) const {
  const auto count = static_cast<Eigen::Index>(positions.size()), waves = static_cast<Eigen::Index>(wave_.size());
  double net = 0, base = 0;
  for (const MirrorImage& image : mirrors_.images)
    if (image.mask == mask) {
      net += image.sign;
      if (base == 0) base = image.sign;
    }
  Eigen::MatrixXd cosine(waves, count), sine(waves, count);
  for (Eigen::Index p = 0; p < count; ++p)
    for (Eigen::Index w = 0; w < waves; ++w) {
      const double phase = dot(wave_[w], positions[p] - from[p]);
      cosine(w, p) = base * std::cos(phase);
      sine(w, p) = base * std::sin(phase);
    }
  const Eigen::MatrixXd even = even_ * cosine, odd = odd_ * sine;
  Eigen::MatrixXd result(harmonics(degree_), count);
  for (std::size_t k = 0; k < even_at_.size(); ++k) result.row(even_at_[k]) = even.row(k);
  for (std::size_t k = 0; k < odd_at_.size(); ++k) result.row(odd_at_[k]) = odd.row(k);
  result.row(0).array() -= net * std::numbers::pi / (split_.alpha * split_.alpha * mirrors_.volume());
  for (Eigen::Index p = 0; p < count; ++p) add_near(mask, from[p], positions[p], result.col(p).data());
  return result;
}

}  // namespace lichtenberg::laplace::spheres
