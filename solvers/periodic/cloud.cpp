#include "solvers/periodic/cloud.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

Cloud gauss_cloud(double alpha, double cutoff) {
  if (!(alpha > 0 && cutoff > 0))
    throw InputError(fmt::format("a cloud's alpha {} and its cutoff {} must be positive", alpha, cutoff));
  Cloud of;
  of.cutoff = cutoff;
  of.potential = [alpha](double r) { return r > 0 ? std::erf(alpha * r) / r : 2 * alpha / std::sqrt(M_PI); };
  of.transform = [alpha](double k) { return std::exp(-k * k / (4 * alpha * alpha)); };
  of.band_limit = INFINITY;
  of.background = M_PI / (alpha * alpha);
  of.dipole_field = 4 * alpha * alpha * alpha / (3 * std::sqrt(M_PI));
  of.neglected = 4 * std::exp(-2 * alpha * alpha * cutoff * cutoff) / cutoff;
  const double steepness = 2 * alpha * alpha * cutoff + 2 / cutoff;  // Growth per derivative beyond the cut-off
  of.neglected_slope = of.neglected * steepness * steepness;
  of.neglected_curvature = of.neglected_slope * steepness * steepness;
  return of;
}

namespace {

/// Prolate function psi_0 on [-1, 1] as a sum of even Legendre polynomials, a_n P_2n, scaled so that its integral from
/// 0 to 1 is 1.
class ProlateFunction {
 public:
  explicit ProlateFunction(double band_limit) {
    // Three-term recurrence of the coefficients of normalized polynomials (Osipov, Rokhlin and Xiao 2013, eq. 2.105).
    // The coefficients fall faster than any power once 2n > band_limit.
    const int terms = 20 + static_cast<int>(band_limit);
    const double c2 = band_limit * band_limit;
    Eigen::VectorXd diagonal(terms), off_diagonal(terms - 1);
    for (int n = 0; n < terms; ++n) {
      const double k = 2 * n;
      diagonal[n] = k * (k + 1) + (2 * k * (k + 1) - 1) / ((2 * k + 3) * (2 * k - 1)) * c2;
      if (n + 1 < terms)
        off_diagonal[n] = (k + 2) * (k + 1) / ((2 * k + 3) * std::sqrt((2 * k + 1) * (2 * k + 5))) * c2;
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(diagonal, off_diagonal);
    eigenvalue_ = solver.eigenvalues()[0];
    const Eigen::VectorXd vector = solver.eigenvectors().col(0);
    for (int n = 0; n < terms; ++n) a_.push_back(vector[n] / vector[0] * std::sqrt(4 * n + 1.0));
    while (std::abs(a_.back()) < 1e-18) a_.pop_back();
  }

  double operator()(double x) const {
    double sum = 0;
    visit(x, [&](int n, double even, double, double) { sum += a_[n] * even; });
    return sum;
  }
  /// Returns the integral from 0 to x.
  double integral(double x) const {
    double sum = 0;
    visit(x, [&](int n, double, double before, double after) { sum += a_[n] * (after - before) / (4 * n + 1); });
    return sum;
  }
  /// Eigenvalue chi of ((1 - x^2) psi')' + (chi - band_limit^2 x^2) psi = 0.
  double eigenvalue() const { return eigenvalue_; }
  /// Integral of x^2 times the function, from 0 to 1.
  double second_moment() const { return a_[0] / 3 + 2 * a_[1] / 15; }
  /// Integral of the squared function, from 0 to 1.
  double square() const {
    double sum = 0;
    for (std::size_t n = 0; n < a_.size(); ++n) sum += a_[n] * a_[n] / (4.0 * n + 1);
    return sum;
  }

 private:
  /// Calls use(n, P_2n, P_(2n-1), P_(2n+1)) at x, with 0 for P_(-1). The two odd polynomials give the integral of P_2n.
  template <class Use>
  void visit(double x, Use&& use) const {
    double before = 0, even = 1, after = x;
    for (int n = 0; n < static_cast<int>(a_.size()); ++n) {
      use(n, even, before, after);
      const int k = 2 * n + 1;
      before = after;
      even = ((2 * k + 1) * x * after - k * even) / (k + 1);
      after = ((2 * k + 3) * x * even - (k + 1) * after) / (k + 2);
    }
  }
  std::vector<double> a_;
  double eigenvalue_ = 0;
};

}  // namespace

Cloud prolate_cloud(double band_limit, double cutoff) {
  if (!(band_limit >= 1 && band_limit <= 100 && cutoff > 0))
    throw InputError(
        fmt::format("a cloud's band limit {} must be from 1 to 100 and its cutoff {} positive", band_limit, cutoff));
  const ProlateFunction psi(band_limit);
  const double middle = psi(0);
  Cloud of;
  of.cutoff = cutoff;
  of.potential = [psi, middle, cutoff](double r) {
    const double x = r / cutoff;
    return x >= 1 ? 1 / r : x > 0 ? psi.integral(x) / r : middle / cutoff;
  };
  of.band_limit = band_limit / cutoff;
  // psi is its own Fourier transform, up to scaling.
  of.transform = [psi, middle, limit = of.band_limit](double k) { return k <= limit ? psi(k / limit) / middle : 0; };
  // Integral of 4 pi r (1 - Phi), integrated by parts twice.
  of.background = 2 * M_PI * cutoff * cutoff * psi.second_moment();
  // The potential begins as psi(0) / cutoff + psi''(0) r^2 / (6 cutoff^3), and psi''(0) = -chi psi(0).
  of.dipole_field = psi.eigenvalue() * middle / (3 * cutoff * cutoff * cutoff);
  // (1/V) sum over k of (4 pi w / k)^2 is 8 times the integral of w^2 beyond the band limit. Of the integral of psi^2
  // over all numbers, the fraction 4 sqrt(pi c) exp(-2c) lies outside of [-1, 1] (Fuchs 1964), half of it at positive
  // wave numbers.
  of.neglected = 8 * of.band_limit * 4 * std::sqrt(M_PI * band_limit) * std::exp(-2 * band_limit) * psi.square() /
                 (middle * middle);
  // Near the cut-off the cloud is steeper than waves below its band limit c allow: c^2 / 2 in place of c. The
  // derivatives of the neglected force therefore exceed it by more than the factor of the wave number. The factors fit
  // a quadrature of psi and its derivatives for band limits from 4 to 18.
  const double wave2 = of.band_limit * of.band_limit;
  of.neglected_slope = of.neglected * wave2 * (0.92 * band_limit - 0.4);
  of.neglected_curvature = of.neglected * wave2 * wave2 * (0.072 * std::pow(band_limit, 3) + 3);
  return of;
}

}  // namespace lichtenberg::periodic
