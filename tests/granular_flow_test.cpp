#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/granular_flow/flow.hpp"
#include "solvers/granular_flow/potential.hpp"
#include "src/theory/stability.hpp"
#include "tests/near.hpp"

namespace granular_flow_test {

using namespace lichtenberg;
using namespace lichtenberg::granular_flow;
using doctest::Approx;
using std::numbers::pi;
using Complex = std::complex<double>;

namespace {

Gas gas_of(double restitution, double charge_number) {
  const auto c = theory::transport_coefficients(restitution);
  return {c.cooling, c.viscosity, c.conduction, c.density_conduction, charge_number};
}

using Wave = std::array<int, 3>;
using Vector3 = std::array<double, 3>;

/// Centre of a cell in units of the box's edges.
Vector3 centre_of(const Grid& grid, std::size_t cell) {
  Vector3 x{};
  for (int axis = grid.dimension - 1; axis >= 0; --axis) {
    x[axis] = (static_cast<double>(cell % grid.cells) + 0.5) / grid.cells;
    cell /= grid.cells;
  }
  return x;
}

Complex phase(const Wave& wave, const Vector3& x) {
  return std::exp(Complex(0, 2 * pi * (wave[0] * x[0] + wave[1] * x[1] + wave[2] * x[2])));
}

double wave_number(const Grid& grid, const Wave& wave) {
  return 2 * pi / grid.length * std::sqrt(wave[0] * wave[0] + wave[1] * wave[1] + wave[2] * wave[2]);
}

/// Unit vector along a wave; across() gives one perpendicular to it in the plane of the first or last two axes.
Vector3 along(const Wave& wave) {
  const double length = std::sqrt(wave[0] * wave[0] + wave[1] * wave[1] + wave[2] * wave[2]);
  return {wave[0] / length, wave[1] / length, wave[2] / length};
}
Vector3 across(const Wave& wave) {
  const Vector3 e = along(wave);
  const double flat = std::hypot(e[0], e[1]);
  return flat > 0 ? Vector3{-e[1] / flat, e[0] / flat, 0} : Vector3{1, 0, 0};
}

/// Amplitudes of density, temperature, i times the velocity along the wave, and the velocity across it.
using Amplitude = Eigen::Vector4cd;

void disturb(Fields& fields, const Grid& grid, const Wave& wave, const Amplitude& a) {
  const Vector3 e = along(wave), f = across(wave);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Complex p = phase(wave, centre_of(grid, cell));
    const double density = 2 * (a[0] * p).real();
    fields.density[cell] += density;
    fields.charge[cell] += density;
    fields.temperature[cell] += 2 * (a[1] * p).real();
    for (int axis = 0; axis < grid.dimension; ++axis)
      fields.velocity[axis][cell] += 2 * ((Complex(0, -1) * a[2] * e[axis] + a[3] * f[axis]) * p).real();
  }
}

Amplitude measure(const Fields& fields, const Grid& grid, const Wave& wave) {
  const Vector3 e = along(wave), f = across(wave);
  Amplitude a = Amplitude::Zero();
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Complex p = std::conj(phase(wave, centre_of(grid, cell))) / static_cast<double>(grid.size());
    a[0] += p * fields.density[cell];
    a[1] += p * fields.temperature[cell];
    for (int axis = 0; axis < grid.dimension; ++axis) {
      a[2] += Complex(0, 1) * p * e[axis] * fields.velocity[axis][cell];
      a[3] += p * f[axis] * fields.velocity[axis][cell];
    }
  }
  return a;
}

/// G 6.39 without the potential, for density, temperature and i times velocity.
Eigen::Matrix3d matrix(const Gas& gas, double k) {
  Eigen::Matrix3d m;
  m << 0, 0, -k,  //
      -gas.cooling / 2 - 2.5 * gas.density_conduction * k * k, -gas.cooling / 4 - 2.5 * gas.conduction * k * k,
      -2.0 / 3 * k,  //
      k / 2 + gas.charge_number / k, k / 2, gas.cooling / 4 - 4.0 / 3 * gas.viscosity * k * k;
  return m;
}

/// Rate of the missing diffusion: the second difference (15, -1)/12 of a sine has (1 - (kh)^4/90) of its exact value.
double missing_diffusion(const Gas& gas, double k, double kh) {
  return std::pow(kh, 4) / 90 * k * k * std::max(4.0 / 3 * gas.viscosity, 2.5 * gas.conduction);
}

/// Compares the growth of all modes of several simultaneous waves with the theory's eigenvalues.
void check_modes(const Gas& gas, const Grid& grid, const std::vector<Wave>& waves) {
  const double amplitude = 1e-5;  // The relative interaction of waves is of this order.
  const double end = 6;           // Modes that decay by exp(-1) and more are still far above the tolerance.
  Fields fields = homogeneous(grid);
  for (const Wave& wave : waves) {
    const Eigen::EigenSolver<Eigen::Matrix3d> solver(matrix(gas, wave_number(grid, wave)));
    Amplitude start = Amplitude::Zero();
    for (int n = 0; n < 3; ++n) start.head<3>() += amplitude * solver.eigenvectors().col(n);
    start[3] = amplitude;
    disturb(fields, grid, wave, start);
  }
  const Fields found = evolve(gas, grid, fields, std::vector{end}, {1e-10})[0];
  for (const Wave& wave : waves) {
    const double k = wave_number(grid, wave), kh = k * grid.step();
    const Eigen::EigenSolver<Eigen::Matrix3d> solver(matrix(gas, k));
    const Amplitude a = measure(found, grid, wave);
    const Eigen::Vector3cd modes = solver.eigenvectors().inverse() * a.head<3>();
    const theory::Modes expected = theory::growth_rates(
        {gas.cooling, gas.viscosity, gas.conduction, gas.density_conduction}, gas.charge_number, std::vector{k})[0];
    const double missing = missing_diffusion(gas, k, kh);  // The modes of this matrix are not orthogonal.
    // The tolerance over the time, relative to the amplitude, adds 2e-5.
    for (int n = 0; n < 3; ++n) {
      const Complex rate = solver.eigenvalues()[n];
      CHECK(std::ranges::any_of(expected.longitudinal, [&](Complex e) { return std::abs(e - rate) < 1e-12; }));
      const Complex grown = std::log(modes[n] / amplitude / std::exp(rate * end)) / end;
      CHECK(std::abs(grown) < 0.01 * std::abs(rate));
      CHECK(std::abs(grown) < 3 * missing + 2e-5);
    }
    const double shear = std::log(std::abs(a[3]) / amplitude) / end;
    CHECK(std::abs(shear - expected.shear) < 0.01 * std::abs(expected.shear));
  }
}

/// Separated charges of both signs; matter attracted to the lines between them becomes dense.
Fields separated(const Grid& grid) {
  Fields fields = homogeneous(grid);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Vector3 x = centre_of(grid, cell);
    fields.charge[cell] = std::cos(2 * pi * x[0]) * std::cos(2 * pi * x[1]);
    fields.density[cell] = 1 + 0.2 * std::sin(2 * pi * (x[0] + 2 * x[1]));
    fields.velocity[0][cell] = 0.3 + 0.1 * std::sin(2 * pi * x[1]);
  }
  return fields;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

double momentum(const Fields& fields, int axis) {
  return std::inner_product(fields.density.begin(), fields.density.end(), fields.velocity[axis].begin(), 0.0);
}

double energy(const Fields& fields, int dimension) {
  double all = 0;
  for (std::size_t cell = 0; cell < fields.density.size(); ++cell) {
    double square = 0;
    for (int axis = 0; axis < dimension; ++axis) square += std::pow(fields.velocity[axis][cell], 2);
    all += fields.density[cell] * (1.5 * fields.temperature[cell] + square);
  }
  return all / static_cast<double>(fields.density.size());
}

/// Sound wave of finite amplitude in a plane, at the given resolution.
Fields wave_at(const Gas& gas, int cells) {
  const Grid grid{2, cells, 40};
  Fields fields = homogeneous(grid);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Vector3 x = centre_of(grid, cell);
    fields.density[cell] = 1 + 0.1 * std::sin(2 * pi * (x[0] + x[1]));
    fields.charge[cell] = fields.density[cell] * (1 + 0.2 * std::cos(2 * pi * x[1]));
    fields.temperature[cell] = 1 + 0.1 * std::cos(2 * pi * x[0]);
    fields.velocity[0][cell] = 0.1 * std::cos(2 * pi * x[1]);
  }
  return evolve(gas, grid, fields, std::vector{4.0}, {1e-9})[0];
}

/// Largest difference between a field and one of twice the resolution, averaged over four cells.
double difference(const std::vector<double>& coarse, const std::vector<double>& fine, int cells) {
  double worst = 0;
  for (int x = 0; x < cells; ++x)
    for (int y = 0; y < cells; ++y) {
      const std::size_t corner = static_cast<std::size_t>(2 * x) * 2 * cells + 2 * y;
      const double mean =
          (fine[corner] + fine[corner + 1] + fine[corner + 2 * cells] + fine[corner + 2 * cells + 1]) / 4;
      worst = std::max(worst, std::abs(coarse[static_cast<std::size_t>(x) * cells + y] - mean));
    }
  return worst;
}

}  // namespace

TEST_CASE("granular hydrodynamics in 2D: modes grow at linear theory's eigenvalues") {
  const std::vector<Wave> waves{{1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 2, 0}, {2, -1, 0}};
  for (const double charge_number : {0.0, 0.9}) check_modes(gas_of(0.7, charge_number), {2, 48, 60}, waves);
}

TEST_CASE("granular hydrodynamics in 3D: modes grow at linear theory's eigenvalues") {
  check_modes(gas_of(0.7, 0.5), {3, 16, 30}, {{1, 0, 0}, {0, 0, 1}, {1, 1, 0}, {1, -1, 1}});
}

TEST_CASE("granular hydrodynamics, constant charges: a wave follows linear theory") {
  const Grid grid{2, 32, 40};
  Gas gas = gas_of(0.7, 0.1);
  gas.charges_last = true;
  const Wave wave{1, 0, 0};
  const double amplitude = 1e-5;
  Fields fields = homogeneous(grid);
  disturb(fields, grid, wave, {amplitude, 0, 0, 0});
  const std::vector<double> times{5, 15, 30};
  const double k0 = wave_number(grid, wave);
  const double missing = missing_diffusion(gas, k0, k0 * grid.step());
  const double tolerance = 1e-10;
  const auto found = evolve(gas, grid, fields, times, {tolerance});
  const auto expected =
      theory::disturbance_evolution({gas.cooling, gas.viscosity, gas.conduction, gas.density_conduction}, 0.1, true,
                                    wave_number(grid, wave), {amplitude, 0, 0}, times);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const Amplitude a = measure(found[k], grid, wave);
    const double size = std::abs(expected[k].density) + std::abs(expected[k].speed);
    // The missing diffusion as above over this time, and the tolerance of about ten steps per unit of time.
    const double bound = (3 * missing + 10 * tolerance / amplitude) * times[k] * size;
    CHECK(std::abs(a[0] - expected[k].density) < bound);
    CHECK(std::abs(a[2] - expected[k].speed) < bound);
  }
}

TEST_CASE("granular hydrodynamics, homogeneous: temperature follows Haff's law") {
  for (const int dimension : {2, 3}) {
    const Grid grid{dimension, 6, 10};
    const Gas gas = gas_of(0.5, 0.3);
    Fields fields = homogeneous(grid);
    std::ranges::fill(fields.temperature, 3.0);
    const std::vector<double> times{0, 1, 30};
    const auto found = evolve(gas, grid, fields, times, {1e-9});
    for (std::size_t k = 0; k < times.size(); ++k) {
      // x = T^(-1/2) obeys dx/dtau = -(zeta/4)(x - 1).
      const double x = 1 + (1 / std::sqrt(3.0) - 1) * std::exp(-gas.cooling / 4 * times[k]);
      CHECK(found[k].temperature[0] == near(1 / (x * x), 1e-6));  // An error of 1e-9 per step over some hundred steps.
      CHECK(std::ranges::minmax(found[k].temperature).min == near(found[k].temperature[0], 1e-12));
      CHECK(found[k].velocity[0][0] == Approx(0).epsilon(1e-12));
    }
  }
}

TEST_CASE("granular hydrodynamics: mass, charge and momentum stay, n and T > 0") {
  const Grid grid{2, 24, 50};
  for (const bool lasting : {false, true}) {
    Gas gas = gas_of(0.7, 0.9);
    gas.charges_last = lasting;
    const Fields start = separated(grid);
    const auto found = evolve(gas, grid, start, std::vector{5.0, lasting ? 10.0 : 40.0}, {1e-4});
    CHECK(std::ranges::max(found[0].density) > 2);
    const double count = static_cast<double>(grid.size());
    for (const Fields& fields : found) {
      // Each of some thousand rates rounds sums of about 100 times epsilon.
      CHECK(std::abs(sum(fields.density) / sum(start.density) - 1) < 1e-13);
      CHECK(std::abs(sum(fields.charge)) / count < 1e-13);
      for (const int axis : {0, 1}) CHECK(std::abs(momentum(fields, axis)) / count < 1e-13);
      CHECK(std::ranges::min(fields.density) > 0);
      CHECK(std::ranges::min(fields.temperature) > 0);
      CHECK(std::isfinite(sum(fields.temperature)));
    }
  }
}

TEST_CASE("granular hydrodynamics: fields converge in second order" * doctest::test_suite("long")) {
  const Gas gas = gas_of(0.8, 0.2);
  const Fields coarse = wave_at(gas, 16), middle = wave_at(gas, 32), fine = wave_at(gas, 64);
  const auto order = [&](const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& c) {
    return std::log2(difference(a, b, 16) / difference(b, c, 32));
  };
  // Products are of second order, all other terms of fourth order.
  for (const double p :
       {order(coarse.density, middle.density, fine.density), order(coarse.charge, middle.charge, fine.charge),
        order(coarse.temperature, middle.temperature, fine.temperature),
        order(coarse.velocity[0], middle.velocity[0], fine.velocity[0])}) {
    CHECK(p > 1.7);
    CHECK(p < 4.5);
  }
}

TEST_CASE("granular hydrodynamics, elastic: energy error decreases with cell size") {
  const Gas gas = gas_of(1, 0);
  double lost[2];
  for (const int fine : {0, 1}) {
    const Grid grid{2, fine ? 32 : 16, 40};
    Fields fields = homogeneous(grid);
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      const Vector3 x = centre_of(grid, cell);
      fields.velocity[0][cell] = 0.3 * std::cos(2 * pi * x[1]);
      fields.density[cell] = 1 + 0.3 * std::sin(2 * pi * (x[0] + x[1]));
    }
    const auto found = evolve(gas, grid, fields, std::vector{0.0, 30.0}, {1e-8});
    lost[fine] = std::abs(energy(found[1], 2) / energy(found[0], 2) - 1);
  }
  // The second-order terms lack (kh)^2/12 of products of three waves: the density's of 0.3 and two of the disturbance.
  // The disturbance has 0.3^2/2 of kinetic energy and as much of density, relative to 3/2 of heat. The loss applies to
  // each radian of sound with k of the density's waves and c^2 = 5/6.
  const double k = 2 * pi * std::sqrt(2.0) / 40, kh = k * 40 / 16, disturbed = 2 * 0.3 * 0.3 / 2 / 1.5;
  CHECK(lost[0] < kh * kh / 12 * k * std::sqrt(5.0 / 6) * 30 * 0.3 * disturbed);
  CHECK(lost[0] > 3 * lost[1]);  // The factor is 4 for second order, less with the fourth-order terms.
}

TEST_CASE("granular hydrodynamics: any number of threads gives identical bits") {
  const Grid grid{2, 12, 50};
  const Gas gas = gas_of(0.7, 0.9);
  const auto alone = evolve(gas, grid, separated(grid), std::vector{3.0}, {1e-4})[0];
  parallel::Team team(3);
  const auto shared = evolve(gas, grid, separated(grid), std::vector{3.0}, {1e-4}, team)[0];
  CHECK(alone.density == shared.density);
  CHECK(alone.temperature == shared.temperature);
  CHECK(alone.velocity[1] == shared.velocity[1]);
}

TEST_CASE("Potential::field of a charge wave: exact, with zero total force") {
  for (const int dimension : {2, 3}) {
    const Grid grid{dimension, 8, 5};
    const Wave wave{1, 2, dimension == 3 ? -1 : 0};
    const double k = wave_number(grid, wave);
    std::vector<double> charge;
    for (std::size_t cell = 0; cell < grid.size(); ++cell)
      charge.push_back(3 + 2 * phase(wave, centre_of(grid, cell)).real());
    Potential potential(grid);
    const auto& field = potential.field(charge);
    for (int axis = 0; axis < dimension; ++axis) {
      double force = 0;
      for (std::size_t cell = 0; cell < grid.size(); ++cell) {
        // -lap psi = 2 cos: div E = 2 cos, E = (2/k) sin along the wave.
        const double expected = 2 / k * along(wave)[axis] * phase(wave, centre_of(grid, cell)).imag();
        CHECK(std::abs(field[axis][cell] - expected) < 1e-14);
        force += charge[cell] * field[axis][cell];
      }
      CHECK(std::abs(force) < 1e-12);
    }
  }
}

TEST_CASE("Potential::field of the highest wave number along x: exact") {
  const Grid grid{2, 8, 5};
  const double highest = pi * grid.cells / grid.length, k = 2 * pi / grid.length;
  std::vector<double> charge;
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Vector3 x = centre_of(grid, cell);  // in units of the box
    charge.push_back(std::sin(highest * grid.length * x[0]) * std::cos(k * grid.length * x[1]));
  }
  Potential potential(grid);
  const auto& field = potential.field(charge);
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Vector3 x = centre_of(grid, cell);
    const double square = highest * highest + k * k;
    const double expected = k / square * std::sin(highest * grid.length * x[0]) * std::sin(k * grid.length * x[1]);
    CHECK(std::abs(field[1][cell] - expected) < 1e-14);
    CHECK(std::abs(field[0][cell]) < 1e-14);  // the slope of sin(highest x) is 0 at all centres
  }
}

TEST_CASE("granular hydrodynamics: impossible grids and fields are refused") {
  const Gas gas = gas_of(0.7, 0);
  const std::vector<double> times{1};
  const Grid good{2, 6, 10};
  for (const Grid& grid : {Grid{1, 8, 10}, Grid{2, 5, 10}, Grid{2, 8, 0}})
    CHECK_THROWS_AS(evolve(gas, grid, homogeneous(grid), times), InputError);
  Fields fields = homogeneous(good);
  fields.density[3] = 0;
  CHECK_THROWS_AS(evolve(gas, good, fields, times), InputError);
  fields = homogeneous(good);
  fields.charge.pop_back();
  CHECK_THROWS_AS(evolve(gas, good, fields, times), InputError);
}

}  // namespace granular_flow_test
