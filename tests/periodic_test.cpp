// Tests of Ewald sums of charges and dipoles.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "solvers/error.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"
#include "tests/source_folder.hpp"

namespace periodic_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using std::numbers::pi;

namespace {

std::vector<double> flat(const nlohmann::json& values) {
  std::vector<double> result;
  for (const auto& value : values.flatten())
    result.push_back(value.is_string() ? std::stod(std::string(value)) : double(value));
  return result;
}

}  // namespace

TEST_CASE("Ewald sum of twenty charges: accurate to the digits of a double") {
  std::ifstream file(source_folder() + "/validation/data/periodic/ewald20.json");
  const nlohmann::json exact = nlohmann::json::parse(file);
  const double length = exact["length"], energy = std::stod(std::string(exact["energy"]));
  const SourceSet sources{{length, length, length}, flat(exact["position"]), flat(exact["charge"])};
  const Response response = by_ewald(sources, 1e-15);
  // The largest terms are about 1, and those of the energy about 5, each rounded a few times by 1.1e-16.
  CHECK(largest_difference(response.potential, flat(exact["potential"])) < 2e-15);
  CHECK(largest_difference(response.force, flat(exact["force"])) < 2e-15);
  CHECK(std::abs(response.energy - energy) < 1e-14);
}

TEST_CASE("Ewald sum: Madelung's constants of two salts and of a single charge") {
  constexpr double rounding = 2e-15;
  CHECK(std::abs(by_ewald(rock_salt()).energy / 4 + 1.7475645946331822) < rounding);
  const SourceSet caesium_chloride = lattice(1, {{0, 0, 0}, {0.5, 0.5, 0.5}}, {1, -1});
  CHECK(std::abs(std::sqrt(0.75) * by_ewald(caesium_chloride).energy + 1.7626747730709884) < rounding);
  const SourceSet lone = lattice(1, {{0.1, 0.2, 0.3}}, {1});
  CHECK(std::abs(2 * by_ewald(lone).energy + 2.8372974794806195) < rounding);
  CHECK(largest(by_ewald(lone).force) < rounding);
}

TEST_CASE("Ewald sum: independent of the splitting alpha, also with net charge") {
  for (const bool neutral : {false, true}) {
    SourceSet sources = random_sources(12, {1, 1.25, 0.75}, 0.1, false, 1);
    const double mean = std::accumulate(sources.charge.begin(), sources.charge.end(), 0.0) / sources.size();
    for (double& q : sources.charge) q -= neutral ? mean : 0;
    const Response expected = by_ewald(sources, 1e-14, 3);
    for (const double alpha : {1.5, 5.0, 8.0}) {
      // The tolerance is 1e-14 of 1 / d^2. The largest terms, 1 / 0.1 and 1 / 0.1^2, round at 1e-14.
      const Response response = by_ewald(sources, 1e-14, alpha);
      CHECK(largest_difference(response.potential, expected.potential) < 1e-13);
      CHECK(largest_difference(response.field, expected.field) < 1e-12);
      CHECK(largest_difference(response.force, expected.force) < 1e-12);
      CHECK(std::abs(response.energy - expected.energy) < 1e-13);
    }
  }
}

TEST_CASE("Ewald cutoffs: field error is 0.03 to 1 times the tolerance") {
  const SourceSet sources = random_sources(60, {1, 1, 1}, 0.05, false, 3);
  const Response exact = by_ewald(sources);
  const double unit = std::pow(60, 2.0 / 3);  // Charge over the squared mean spacing.
  for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
    const double error = largest_difference(by_ewald(sources, tolerance).field, exact.field) / unit;
    CHECK(error < tolerance);
    CHECK(error > 0.03 * tolerance);  // Random positions come close to the bound on sums of magnitudes.
  }
}

TEST_CASE("Ewald sum of charges: forces equal negative energy derivatives") {
  SourceSet sources = random_sources(6, {1, 1.25, 0.75}, 0.2, false, 2);
  const Response at = by_ewald(sources);
  const double step = 1e-3;
  const double bound = 4 * std::pow(step, 4) / std::pow(0.2, 6);  // step^4 / 30 times the fifth derivative of 1/r.
  for (int k = 0; k < 18; ++k)
    CHECK(std::abs(energy_slope(sources.position[k], step, [&] { return by_ewald(sources).energy; }) + at.force[k]) <
          bound);
}

TEST_CASE("Ewald forces: zero sum, independent of order, origin and images") {
  for (const bool dipoles : {false, true}) {
    const SourceSet sources = random_sources(12, {1, 1.25, 0.75}, 0.1, dipoles, 4);
    const Response response = by_ewald(sources);
    const double rounding = 1e-14 * largest(response.force);
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (int i = 0; i < sources.size(); ++i) sum += response.force[3 * i + k];
      CHECK(std::abs(sum) < rounding);
    }
    SourceSet moved = sources;
    std::reverse(moved.charge.begin(), moved.charge.end());
    for (int i = 0; i < sources.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const int from = 3 * (sources.size() - 1 - i) + k;
        moved.position[3 * i + k] = sources.position[from] + 0.3 + (i % 3 - 1) * sources.lengths[k];
        if (dipoles) moved.dipole[3 * i + k] = sources.dipole[from];
      }
    Response other = by_ewald(moved);
    std::reverse(other.potential.begin(), other.potential.end());
    CHECK(largest_difference(other.potential, response.potential) < 1e-14 * largest(response.potential));
    for (int i = 0; i < sources.size(); ++i)
      for (int k = 0; k < 3; ++k)  // Moved positions are rounded by 2e-16, which the gradients of the fields multiply.
        CHECK(std::abs(other.force[3 * (sources.size() - 1 - i) + k] - response.force[3 * i + k]) < 10 * rounding);
  }
}

TEST_CASE("Ewald sum of two cells in a row: each has the result of one cell") {
  const SourceSet cell = random_sources(5, {1, 1.25, 0.75}, 0.2, true, 5);
  SourceSet two = cell;
  two.lengths.z *= 2;
  for (const double q : cell.charge) two.charge.push_back(q);
  for (const double mu : cell.dipole) two.dipole.push_back(mu);
  for (int k = 0; k < 15; ++k) two.position.push_back(cell.position[k] + (k % 3 == 2 ? cell.lengths.z : 0));
  const Response expected = by_ewald(cell), response = by_ewald(two);
  CHECK(std::abs(response.energy - 2 * expected.energy) < 1e-13 * std::abs(expected.energy));
  for (int k = 0; k < 15; ++k)
    for (const int image : {0, 15})
      CHECK(std::abs(response.force[k + image] - expected.force[k]) < 1e-13 * largest(expected.force));
}

TEST_CASE("Ewald sum: scaling lengths and charges by powers of two is exact") {
  for (const bool dipoles : {false, true}) {
    const SourceSet sources = random_sources(12, {1, 1.25, 0.75}, 0.1, dipoles, 6);
    SourceSet scaled = sources;
    for (double& x : scaled.position) x *= 2;
    for (int k = 0; k < 3; ++k) scaled.lengths[k] *= 2;
    for (double& q : scaled.charge) q *= 0.25;
    for (double& mu : scaled.dipole) mu *= 0.5;
    Ewald ewald;
    const Response expected = evaluated(ewald, sources), response = evaluated(ewald, scaled);
    CHECK(response.energy == expected.energy / 32);
    for (int i = 0; i < sources.size(); ++i) CHECK(response.potential[i] == expected.potential[i] / 8);
    for (int k = 0; k < 3 * sources.size(); ++k) {
      CHECK(response.field[k] == expected.field[k] / 16);
      CHECK(response.force[k] == expected.force[k] / 64);
    }
  }
}

TEST_CASE("Ewald sum: threads and evaluation of selected charges change no bit") {
  const SourceSet sources = random_sources(30, {1, 1, 1}, 0.05, true, 7);
  Ewald ewald;
  const Response expected = evaluated(ewald, sources);
  for (const int threads : {2, 4}) {
    parallel::Team team(threads);
    const Response response = evaluated(ewald, sources, team);
    CHECK(response.potential == expected.potential);
    CHECK(response.force == expected.force);
    CHECK(response.energy == expected.energy);
  }
  Response sample;
  ewald.evaluate_at(std::vector<int>{17, 3}, sources, parallel::Team::single(), sample);
  CHECK(sample.potential == std::vector{expected.potential[17], expected.potential[3]});
  CHECK(sample.force[3] == expected.force[9]);
  CHECK(sample.field.size() == 6);
}

TEST_CASE("Ewald sum: inconsistent sources are refused with an error message") {
  SourceSet sources = rock_salt();
  sources.charge.pop_back();
  CHECK(message_of([&] { by_ewald(sources); }) ==
        "7 sources have 24 coordinates and 0 components of dipoles: 21 are needed");
  sources.lengths.y = 0;
  CHECK(message_of([&] { by_ewald(sources); }) ==
        "a periodic box has the lengths 2, 0 and 2: all must be positive and finite");
  CHECK(message_of([&] { by_ewald(rock_salt(), 0); }) == "a tolerance of Ewald's sum is 0: it must be positive");
  CHECK(by_ewald(SourceSet{}).energy == 0);
}

}  // namespace periodic_test
