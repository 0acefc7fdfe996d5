#include "src/theory/stability.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;
using Root = std::complex<double>;
using Roots = std::array<Root, 3>;

/// Returns the eigenvalues of G 6.39 for density, temperature and i times velocity, for which the matrix is real.
/// Charges move with the grains, so their potential is -density/k^2. The fourth eigenvalue is 0, for charges without
/// grains. Density is scaled such that its coupling with velocity is antisymmetric; otherwise small k would lose
/// digits.
Roots longitudinal_roots(const TransportCoefficients& c, double charge_number, double k) {
  const double square = k * k, restoring = std::sqrt(square / 2 + charge_number);
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 2) = -restoring;
  m(1, 0) = -(c.cooling / 2 + 2.5 * c.density_conduction * square) * k / restoring;
  m(1, 1) = -c.cooling / 4 - 2.5 * c.conduction * square;
  m(1, 2) = -2.0 / 3 * k;
  m(2, 0) = restoring;
  m(2, 1) = k / 2;
  m(2, 2) = c.cooling / 4 - 4.0 / 3 * c.viscosity * square;
  const Eigen::Vector3cd roots = Eigen::EigenSolver<Eigen::Matrix3d>(m, false).eigenvalues();
  return {roots[0], roots[1], roots[2]};
}

/// Returns the roots in the order that is nearest to the expected values.
Roots in_order(Roots roots, const Roots& expected) {
  std::array<int, 3> order{0, 1, 2}, best = order;
  double least = INFINITY;
  do {
    double distance = 0;
    for (int n = 0; n < 3; ++n) distance += std::abs(roots[order[n]] - expected[n]);
    if (distance < least) least = distance, best = order;
  } while (std::next_permutation(order.begin(), order.end()));
  return {roots[best[0]], roots[best[1]], roots[best[2]]};
}

Roots extrapolated(const Modes& before, const Modes& now, double k) {
  const double far = (k - now.wave_number) / (now.wave_number - before.wave_number);
  Roots roots;
  for (int n = 0; n < 3; ++n) roots[n] = now.longitudinal[n] + far * (now.longitudinal[n] - before.longitudinal[n]);
  return roots;
}

Roots sorted_by_growth(Roots roots) {
  std::ranges::sort(roots,
                    [](Root a, Root b) { return a.real() != b.real() ? a.real() > b.real() : a.imag() > b.imag(); });
  return roots;
}

/// Returns the sign changes of a function of the wave number, found on `points` intervals of a logarithmic scale.
std::vector<double> sign_changes(const std::function<double(double)>& f, double least, double most) {
  constexpr int points = 400;
  std::vector<double> found;
  double k = least, value = f(least);
  for (int n = 1; n <= points; ++n) {
    const double next = least * std::pow(most / least, n / static_cast<double>(points)), there = f(next);
    if (value * there < 0) {
      std::uintmax_t steps = 100;
      const auto [low, high] = boost::math::tools::toms748_solve(f, k, next, value, there,
                                                                 boost::math::tools::eps_tolerance<double>(48), steps);
      found.push_back((low + high) / 2);
    }
    k = next, value = there;
  }
  return found;
}

std::vector<CriticalWave> merged(const std::vector<double>& heat, const std::vector<double>& sound) {
  std::vector<CriticalWave> waves;
  for (const double k : heat) waves.push_back({k, false});
  for (const double k : sound) waves.push_back({k, true});
  std::ranges::sort(waves, {}, &CriticalWave::wave_number);
  return waves;
}

}  // namespace

TransportCoefficients transport_coefficients(double restitution) {
  const double e = restitution;
  if (!(e > 0 && e <= 1))
    throw InputError(fmt::format("transport coefficients are for a restitution coefficient in (0, 1], not for {}", e));
  const double a2 = 16 * (1 - e) * (1 - 2 * e * e) / (81 - 17 * e + 30 * e * e * (1 - e));
  const double nu1 = (9 - 3 * e) * (1 + e) / 12 * (1 - a2 / 32);
  const double nu2 = (1 + e) / 2 * (1 + 33 * (1 - e) / 16 + (19 - 3 * e) / 512 * a2);
  const double zeta = 5.0 / 12 * (1 - e * e) * (1 + 3 * a2 / 16);
  const double kappa = (1 + 2 * a2) / (nu2 - 3 * zeta);
  return {.cooling = zeta,
          .viscosity = 1 / (nu1 - zeta / 2),
          .conduction = kappa,
          .density_conduction = 2 * (zeta * kappa + 2 * a2 / 3) / (4 * nu2 / 3 - 3 * zeta)};
}

double hydrodynamic_length(double density) { return 5 / (16 * std::sqrt(2 * pi) * density); }

double charge_number(double coupling, double density, double mean_charge, double temperature) {
  const double length = hydrodynamic_length(density);
  return 2 * pi * coupling * density * mean_charge * mean_charge * length * length / temperature;
}

std::vector<Modes> growth_rates(const TransportCoefficients& c, double charge_number, std::span<const double> k) {
  std::vector<Modes> modes;
  for (const double wave_number : k) {
    Roots roots = sorted_by_growth(longitudinal_roots(c, charge_number, wave_number));
    const std::size_t n = modes.size();
    if (n == 1) roots = in_order(roots, modes[0].longitudinal);
    if (n > 1) roots = in_order(roots, extrapolated(modes[n - 2], modes[n - 1], wave_number));
    modes.push_back({wave_number, roots, c.cooling / 4 - c.viscosity * wave_number * wave_number});
  }
  return modes;
}

std::vector<Disturbance> disturbance_evolution(const TransportCoefficients& c, double charge_number, bool charges_last,
                                               double k, const Disturbance& start, std::span<const double> times) {
  const double square = k * k;
  // Real and imaginary parts are independent: y has the first in elements 0 to 2, the second in elements 3 to 5.
  const auto rates = [&](double time, std::span<const double> y, std::span<double> rate) {
    const double number = charge_number * (charges_last ? std::exp(c.cooling / 2 * time) : 1);
    for (int part = 0; part < 6; part += 3) {
      const double density = y[part], temperature = y[part + 1], speed = y[part + 2];
      rate[part] = -k * speed;
      rate[part + 1] = -(c.cooling / 2 + 2.5 * c.density_conduction * square) * density -
                       (c.cooling / 4 + 2.5 * c.conduction * square) * temperature - 2.0 / 3 * k * speed;
      rate[part + 2] = (k / 2 + number / k) * density + k / 2 * temperature +
                       (c.cooling / 4 - 4.0 / 3 * c.viscosity * square) * speed;
    }
  };
  const double size = std::abs(start.density) + std::abs(start.temperature) + std::abs(start.speed);
  const Ode ode{.rates = rates, .absolute = std::vector(6, 1e-12 * size), .relative = 1e-10};
  const std::vector<double> y{start.density.real(), start.temperature.real(), start.speed.real(),
                              start.density.imag(), start.temperature.imag(), start.speed.imag()};
  std::vector<Disturbance> found;
  for (const auto& now : integrate(ode, 0, y, times))
    found.push_back({{now[0], now[3]}, {now[1], now[4]}, {now[2], now[5]}});
  return found;
}

Cubic characteristic(const TransportCoefficients& c, double charge_number, double k) {
  const double square = k * k, restoring = square / 2 + charge_number;
  const double velocity = c.cooling / 4 - 4.0 / 3 * c.viscosity * square;
  const double temperature = -c.cooling / 4 - 2.5 * c.conduction * square;
  const double by_density = -c.cooling / 2 - 2.5 * c.density_conduction * square;
  return {-(velocity + temperature), velocity * temperature + square / 3 + restoring,
          -restoring * temperature + square / 2 * by_density};
}

std::vector<CriticalWave> critical_waves(const TransportCoefficients& c, double charge_number, double least,
                                         double most) {
  const auto roots = [&](double k) { return longitudinal_roots(c, charge_number, k); };
  const auto product = [&](double k) {
    const Roots r = roots(k);
    return (r[0] * r[1] * r[2]).real();
  };
  const auto sums = [&](double k) {
    const Roots r = roots(k);
    return ((r[0] + r[1]) * (r[1] + r[2]) * (r[2] + r[0])).real();
  };
  std::vector<double> sound;
  for (const double k : sign_changes(sums, least, most))
    if (std::ranges::any_of(roots(k), [](Root r) { return r.imag() != 0; })) sound.push_back(k);
  return merged(sign_changes(product, least, most), sound);
}

std::vector<CriticalWave> routh_hurwitz_waves(const TransportCoefficients& c, double charge_number, double least,
                                              double most) {
  const auto constant = [&](double k) { return characteristic(c, charge_number, k).c; };
  const auto hurwitz = [&](double k) {
    const Cubic cubic = characteristic(c, charge_number, k);
    return cubic.a * cubic.b - cubic.c;
  };
  std::vector<double> sound;
  for (const double k : sign_changes(hurwitz, least, most))
    if (characteristic(c, charge_number, k).b > 0) sound.push_back(k);  // b <= 0: two real roots of opposite sign
  return merged(sign_changes(constant, least, most), sound);
}

double critical_shear(const TransportCoefficients& c) { return std::sqrt(c.cooling / (4 * c.viscosity)); }

}  // namespace lichtenberg::theory
