// Tests of given and induced dipoles and of pair sums.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/short_range.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_dipoles_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using std::numbers::pi;

namespace {

parallel::Team& alone = parallel::Team::single();

/// Infinite row of touching grains of diameter 1 with period `n`. Other rows are so far away that their field, which
/// decays as exp(-2 pi distance), vanishes. Along the row T is 4 zeta(3), from 2/r^3 of the grains on both sides.
SourceSet chain(int n) {
  SourceSet sources{.lengths = {7, 7, static_cast<double>(n)}, .charge = std::vector<double>(n)};
  for (int i = 0; i < n; ++i)
    for (const double x : {0.0, 0.0, static_cast<double>(i)}) sources.position.push_back(x);
  return sources;
}
constexpr double chain_sum = 4 * 1.2020569031595942;

std::vector<double> along_z(int n) {
  std::vector<double> field(3 * n);
  for (int i = 0; i < n; ++i) field[3 * i + 2] = 1;
  return field;
}

/// Two equal charges with dipoles, one at the origin and one at height `z`.
SourceSet two(double z, double charge, double dipole, double length) {
  return {.lengths = {length, length, length},
          .position = {0, 0, 0, 0, 0, z},
          .charge = {charge, charge},
          .dipole = {0, 0, dipole, 0, 0, dipole}};
}

std::vector<Pair> all_pairs(int n) {
  std::vector<Pair> pairs;
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) pairs.push_back({i, j});
  return pairs;
}

Response by_shifted_force(const SourceSet& sources, double cutoff, double alpha = 0, int threads = 1) {
  parallel::Team team(threads);
  Response response;
  ShiftedForce(cutoff, alpha).evaluate(sources, all_pairs(sources.size()), team, response);
  return response;
}

Response with_induced(const SourceSet& sources, DipoleSum variant, double tolerance = 1e-13,
                      std::vector<double> dipole = {}) {
  Ewald ewald(1e-14);
  Response response;
  InducedDipoles(ewald, variant, 0.075, tolerance).evaluate(sources, {}, alone, dipole, response);
  return response;
}

/// Grains of diameter 0.9 to 1. No two are at a distance close to half the box's length (2), so a small step keeps each
/// pair's nearest image.
SourceSet grains() { return random_sources(8, {4, 4.5, 5}, 0.9, false, 8); }

double worst_slope_error(SourceSet sources, const std::vector<double>& force, DipoleSum variant) {
  double worst = 0;
  for (std::size_t k = 0; k < force.size(); ++k) {
    const double slope = energy_slope(sources.position[k], 2e-3, [&] { return with_induced(sources, variant).energy; });
    worst = std::max(worst, std::abs(slope + force[k]));
  }
  return worst;
}

}  // namespace

TEST_CASE("Ewald sum, one dipole in a cube: field is 4 pi / (3 L^3) times dipole") {
  const double length = 1.5;
  SourceSet lone = lattice(length, {{0.1, 0.2, 0.3}}, {0});
  lone.dipole = {0.3, -0.4, 0.5};
  const Response response = by_ewald(lone);
  for (int k = 0; k < 3; ++k) {
    CHECK(std::abs(response.field[k] - 4 * pi / 3 * lone.dipole[k] / (length * length * length)) < 2e-15);
    CHECK(std::abs(response.force[k]) < 2e-15);
  }
}

TEST_CASE("Ewald sum with dipoles: independent of the splitting parameter alpha") {
  const SourceSet sources = random_sources(12, {1, 1.25, 0.75}, 0.1, true, 1);
  const Response expected = by_ewald(sources, 1e-14, 3);
  for (const double alpha : {1.5, 5.0, 8.0}) {
    const Response response = by_ewald(sources, 1e-14, alpha);
    const double rounding = 4e-15;  // Terms are as large as the largest results, and each is rounded about ten times.
    CHECK(largest_difference(response.potential, expected.potential) < rounding * largest(expected.potential));
    CHECK(largest_difference(response.field, expected.field) < rounding * largest(expected.field));
    CHECK(largest_difference(response.force, expected.force) < rounding * largest(expected.force));
    CHECK(std::abs(response.energy - expected.energy) < rounding * std::abs(expected.energy));
  }
}

TEST_CASE("Ewald sum with dipoles: forces and fields equal energy derivatives") {
  SourceSet sources = random_sources(6, {1, 1.25, 0.75}, 0.2, true, 2);
  const Response at = by_ewald(sources);
  const auto energy = [&] { return by_ewald(sources).energy; };
  const double step = 1e-3;
  const double bound =
      2 * 84 * std::pow(step, 4) / std::pow(0.2, 8);  // step^4 / 30 times the fifth derivative of 1/r^3.
  for (int k = 0; k < 18; ++k) {
    CHECK(std::abs(energy_slope(sources.position[k], step, energy) + at.force[k]) < bound);
    // The energy is quadratic in the dipoles: the differences are exact, except for rounding of about 100 / 0.1.
    CHECK(std::abs(energy_slope(sources.dipole[k], 0.1, energy) + at.field[k]) < 1e-12);
  }
}

TEST_CASE("minimum image: charges and dipoles interact across the box's side") {
  MinimumImage near;
  const Response charges = evaluated(near, two(9.5, 2, 0, 10));  // The distance is 0.5.
  CHECK(charges.energy == doctest::Approx(8).epsilon(1e-15));
  CHECK(charges.potential[0] == doctest::Approx(4).epsilon(1e-15));
  CHECK(charges.force[2] == doctest::Approx(16).epsilon(1e-15));
  const Response dipoles = evaluated(near, two(2, 0, 3, 10));
  CHECK(dipoles.energy == doctest::Approx(-2 * 9.0 / 8).epsilon(1e-15));
  CHECK(dipoles.field[2] == doctest::Approx(2 * 3.0 / 8).epsilon(1e-15));
  CHECK(dipoles.force[2] == doctest::Approx(6 * 9.0 / 16).epsilon(1e-15));
  CHECK(dipoles.force[5] == -dipoles.force[2]);
}

TEST_CASE("minimum image: cutoff is half the box, or the whole box on request") {
  SourceSet far = two(5, 1, 0, 10);
  far.position[3] = 0.1;
  MinimumImage half, all(MinimumImage::Reach::box);
  CHECK(evaluated(half, far).energy == 0);
  CHECK(evaluated(all, far).energy == doctest::Approx(1 / std::hypot(5, 0.1)).epsilon(1e-15));
}

TEST_CASE("Ewald sum in a large neutral box: agrees with the minimum image") {
  SourceSet sources = random_sources(6, {1, 1, 1}, 0.2, true, 9);
  sources.charge.back() -= std::accumulate(sources.charge.begin(), sources.charge.end(), 0.0);
  sources.lengths = {400, 400, 400};
  MinimumImage near;
  const Response expected = evaluated(near, sources), response = by_ewald(sources, 1e-10, 0.1);
  // The images act as 4 pi / (3 V) times the total moment, at most 6 (1 + sqrt(3)), on moments of that size.
  const double bound = 4 * pi / 3 * std::pow(17 / 400.0, 2) / 400;
  CHECK(std::abs(response.energy - expected.energy) < bound);
  CHECK(largest_difference(response.force, expected.force) < bound);
}

TEST_CASE("shifted force: equals its energy's derivative, vanishes at the cutoff") {
  for (const double alpha : {0.0, 1.5}) {
    SourceSet sources = random_sources(6, {2, 2.5, 2}, 0.4, false, 2);
    const Response at = by_shifted_force(sources, 0.95, alpha);
    CHECK(at.energy != 0);
    for (int k = 0; k < 18; ++k) {
      const auto energy = [&] { return by_shifted_force(sources, 0.95, alpha).energy; };
      // As for Ewald's sum. A pair that crosses the cutoff, where the slope of the force jumps, would add the step
      // times this jump, 2e-3.
      CHECK(std::abs(energy_slope(sources.position[k], 1e-3, energy) + at.force[k]) < 4e-12 / std::pow(0.4, 6));
    }
    SourceSet pair = two(0.95 - 1e-9, 1, 0, 2);
    pair.dipole = {};
    const double itself =
        by_shifted_force({.lengths = {2, 2, 2}, .position = {0, 0, 0}, .charge = {1}}, 0.95, alpha).energy;
    // (c - r)^2 in order of magnitude.
    CHECK(std::abs(by_shifted_force(pair, 0.95, alpha).energy - 2 * itself) < 1e-15);
    CHECK(largest(by_shifted_force(pair, 0.95, alpha).force) < 1e-8);  // c - r in order of magnitude.
    pair.position[5] = 0.96;
    CHECK(largest(by_shifted_force(pair, 0.95, alpha).force) == 0);
  }
}

TEST_CASE("shifted force: opposite charges cancel, rock salt has Madelung's energy") {
  SourceSet sources = random_sources(6, {2, 2.5, 2}, 0.4, false, 2);
  const double expected = by_shifted_force(sources, 0.95, 1.5).energy, separation = 0x1p-20;
  for (const double sign : {1.0, -1.0}) {
    sources.charge.push_back(sign);
    for (const double x : {1.0, 1.0, 1.0 + (sign < 0 ? separation : 0)}) sources.position.push_back(x);
  }
  CHECK(std::abs(by_shifted_force(sources, 0.95, 1.5).energy + 1 / separation - expected) <
        1e-5);  // Slopes of about 10, times the distance.
  SourceSet salt{.lengths = {8, 8, 8}};
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 8; ++z) {
        for (const int coordinate : {x, y, z}) salt.position.push_back(coordinate);
        salt.charge.push_back((x + y + z) % 2 == 0 ? 1 : -1);
      }
  CHECK(2 * by_shifted_force(salt, 4, 0.5).energy / 512 == doctest::Approx(-1.7476).epsilon(0.01));
}

TEST_CASE("shifted force: threads give identical bits; bad cutoffs are refused") {
  const SourceSet sources = random_sources(60, {2, 2, 2}, 0.1, false, 3);  // 1770 pairs form more than one work item.
  const Response one = by_shifted_force(sources, 0.9), four = by_shifted_force(sources, 0.9, 0, 4);
  CHECK(four.force == one.force);
  CHECK(four.potential == one.potential);
  CHECK(message_of([&] { by_shifted_force(sources, 1.5); }) ==
        "the shifted force ends at 1.5: it must be above 0 and at most half of the box's shortest length, 2");
  CHECK(message_of([&] { by_shifted_force(two(1, 1, 1, 10), 2); }) ==
        "the shifted force is defined for charges only, not for dipoles");
}

TEST_CASE("induced dipoles of a touching chain: closed form up to divergence") {
  Ewald ewald(1e-14);
  for (const int n : {1, 3}) {
    const SourceSet row = chain(n);
    const DipoleField field_of = field_by(ewald, row, {}, alone);
    for (const double polarizability : {0.005, 0.04, 0.075, 0.12}) {
      std::vector<double> dipole(3 * n);
      solve_dipoles(field_of, along_z(n), polarizability, 1e-13, dipole);
      for (int i = 0; i < n; ++i)  // The tolerance is 1e-13 of the residual, which 1 - A T divides.
        CHECK(std::abs(dipole[3 * i + 2] * (1 - polarizability * chain_sum) / polarizability - 1) < 1e-12);
    }
    CHECK(largest_polarizability(field_of, n) == doctest::Approx(1 / chain_sum).epsilon(1e-9));
    std::vector<double> dipole(3 * n);
    CHECK(message_of([&] { solve_dipoles(field_of, along_z(n), 0.21, 1e-13, dipole); }) ==
          "at a polarizability of 0.21 the mutual polarization of the dipoles at these positions diverges: it must be "
          "below 0.207977");
  }
}

TEST_CASE("check_stability: refuses a growing mode that charges do not excite") {
  Ewald ewald(1e-14);
  SourceSet row = chain(6);
  // The field along the row is odd about a charge and does not excite the uniform mode.
  row.charge = {1, 0, 0, -1, 0, 0};
  const auto refusal = [&](double polarizability) {
    return message_of(
        [&] { InducedDipoles(ewald, DipoleSum::ewald, polarizability, 1e-10).check_stability(row, {}, alone); });
  };
  for (const double polarizability : {0.12, 0.2}) CHECK(refusal(polarizability) == "");
  for (const double polarizability : {0.21, 0.25}) {
    CAPTURE(polarizability);
    CHECK(refusal(polarizability) == fmt::format("at a polarizability of {:g} the mutual polarization of the dipoles "
                                                 "at these positions diverges: it must be below 0.207977",
                                                 polarizability));
    std::vector<double> dipole;
    Response response;
    const InducedDipoles induced(ewald, DipoleSum::ewald, polarizability, 1e-10);
    // The evaluation does not detect the mode.
    CHECK(message_of([&] { induced.evaluate(row, {}, alone, dipole, response); }) == "");
  }
}

TEST_CASE("Jacobi iteration of induced dipoles: error times 0.361 for each sweep") {
  Ewald ewald(1e-14);
  const SourceSet row = chain(2);
  const DipoleField field_of = field_by(ewald, row, {}, alone);
  const double polarizability = 0.075, solution = polarizability / (1 - polarizability * chain_sum);
  std::vector<double> dipole(6), field(6);
  double error = solution;
  for (int sweep = 0; sweep < 8; ++sweep) {
    field_of(dipole, field);
    for (int k = 0; k < 6; ++k) dipole[k] = polarizability * (along_z(2)[k] + field[k]);
    const double before = std::exchange(error, solution - dipole[2]);
    // Rounding, divided by the last error of 3e-5.
    CHECK(std::abs(error / before - polarizability * chain_sum) < 1e-10);
  }
  CHECK(polarizability * chain_sum == doctest::Approx(0.361).epsilon(2e-3));
}

TEST_CASE("largest_polarizability of a close packing: is 3 / (4 pi sqrt(2))") {
  const SourceSet packed =
      lattice(std::sqrt(2.0), {{0, 0, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}, {0, 0, 0, 0});
  Ewald ewald(1e-14);
  const double largest = largest_polarizability(field_by(ewald, packed, {}, alone), 4);
  CHECK(largest == doctest::Approx(3 / (4 * pi * std::sqrt(2.0))).epsilon(1e-9));
}

TEST_CASE("induced dipoles: forces are energy derivatives, not in source's variant") {
  const SourceSet sources = grains();
  for (const DipoleSum variant : {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image}) {
    const Response at = with_induced(sources, variant);
    // step^4 / 30 times the fifth derivative, 120 / 0.9^6 for charges and no more for their dipoles: 2e-10.
    CHECK(worst_slope_error(sources, at.force, variant) < 2e-10);
    CHECK(at.energy < by_ewald(sources).energy - 0.05);
  }
  CHECK(worst_slope_error(sources, with_induced(sources, DipoleSum::source).force, DipoleSum::source) > 1e-3);
}

TEST_CASE("induced dipoles, source's variant: force derivatives are asymmetric") {
  const auto crosswise = [](DipoleSum variant) {
    const double step = 1e-4;
    SourceSet sources = grains();
    const auto slope = [&](int row, int column) {  // Derivative of one force component by another coordinate.
      const double at = sources.position[column];
      sources.position[column] = at + step;
      const double above = with_induced(sources, variant).force[row];
      sources.position[column] = at - step;
      const double below = with_induced(sources, variant).force[row];
      sources.position[column] = at;
      return (above - below) / (2 * step);
    };
    double difference = 0;
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column < row; ++column)
        difference = std::max(difference, std::abs(slope(row, column) - slope(column, row)));
    return difference;
  };
  // step^2 / 6 times the fourth derivative of the energy, 24 / 0.9^5.
  for (const DipoleSum variant : {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image})
    CHECK(crosswise(variant) < 7e-8);
  CHECK(crosswise(DipoleSum::source) > 5e-4);
}

TEST_CASE("induced dipoles: residual within tolerance, energy error is its square") {
  const SourceSet sources = grains();
  Ewald ewald(1e-14);
  const double tolerance = 1e-4;
  for (const DipoleSum variant :
       {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image, DipoleSum::source}) {
    const InducedDipoles induced(ewald, variant, 0.075, tolerance);
    std::vector<double> dipole;
    Response response;
    const int applications = induced.evaluate(sources, {}, alone, dipole, response);
    double residual = 0, field = 0;
    for (std::size_t k = 0; k < dipole.size(); ++k) {
      residual = std::hypot(residual, response.field[k] - dipole[k] / 0.075);
      field = std::hypot(field, response.field[k]);
    }
    CHECK(residual < tolerance * field);
    CHECK(residual > 0.02 * tolerance * field);  // One application reduces the residual by less than a factor of ten.
    CHECK(applications < 8);
    // A/2 residual^2 / (1 - A rho), for a field whose squares sum to about 2 and A rho < 1/2.
    CHECK(std::abs(response.energy - with_induced(sources, variant).energy) < 0.15 * tolerance * tolerance);
    CHECK(induced.evaluate(sources, {}, alone, dipole, response) <= 1);  // The previous dipoles are the initial guess.
  }
}

TEST_CASE("potential with induced dipoles: from the sum that gives their forces") {
  const SourceSet sources = grains();
  const std::vector<double> charges = by_ewald(sources).potential;
  Ewald ewald(1e-14);
  MinimumImage near;
  for (const DipoleSum variant :
       {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image, DipoleSum::source}) {
    SourceSet dipoles = sources;
    Response response;
    InducedDipoles(ewald, variant, 0.075, 1e-13).evaluate(sources, {}, alone, dipoles.dipole, response);
    dipoles.charge.assign(sources.size(), 0);
    const bool far = variant == DipoleSum::ewald || variant == DipoleSum::mixed_consistent;
    std::vector<double> expected = evaluated(far ? static_cast<Sum&>(ewald) : near, dipoles).potential;
    for (int i = 0; i < sources.size(); ++i) expected[i] += charges[i];
    CHECK(largest_difference(response.potential, expected) < 1e-14);
  }
}

TEST_CASE("polarizability 0: induces no dipole; a negative one is refused") {
  const SourceSet sources = grains();
  Ewald ewald(1e-14);
  std::vector<double> dipole = {1, 2, 3};
  Response response;
  CHECK(InducedDipoles(ewald, DipoleSum::ewald, 0, 1e-6).evaluate(sources, {}, alone, dipole, response) == 0);
  CHECK(dipole == std::vector<double>(24));
  CHECK(response.energy == by_ewald(sources).energy);
  CHECK(message_of([&] {
          InducedDipoles(ewald, DipoleSum::ewald, -1, 1e-6).evaluate(sources, {}, alone, dipole, response);
        }) == "a polarizability is -1: it must not be negative");
}

TEST_CASE("DipolePredictor: has Kolafa's weights and can restore its history") {
  const std::vector<std::vector<double>> weights = {
      {1}, {2, -1}, {2.5, -2, 0.5}, {2.8, -2.8, 1.2, -0.2}, {2.8, -2.8, 1.2, -0.2}};
  for (std::size_t steps = 1; steps <= weights.size(); ++steps)
    for (std::size_t j = 0; j < weights[steps - 1].size(); ++j) {
      DipolePredictor predictor;  // A dipole that was 1 in one step, j + 1 steps ago.
      for (std::size_t step = steps; step-- > 0;) predictor.keep({step == j ? 1.0 : 0.0});
      CHECK(predictor.predict()[0] == doctest::Approx(weights[steps - 1][j]).epsilon(1e-15));
    }
  DipolePredictor predictor, resumed;
  CHECK(predictor.predict().empty());
  for (int step = 0; step < 5; ++step) predictor.keep({1.0 + step, -2.0 * step});
  CHECK(predictor.history().size() == 4);
  CHECK(predictor.predict()[0] == doctest::Approx(6).epsilon(1e-15));
  CHECK(predictor.predict()[1] == doctest::Approx(-10).epsilon(1e-15));
  DipolePredictor corrected = predictor;
  corrected.replace({4, -2});  // Replaces 5, -8, of which the prediction took 2.8.
  CHECK(corrected.history().size() == 4);
  CHECK(corrected.predict()[0] == doctest::Approx(3.2).epsilon(1e-15));
  resumed.restore(predictor.history());
  CHECK(resumed.predict() == predictor.predict());
}

}  // namespace periodic_dipoles_test
