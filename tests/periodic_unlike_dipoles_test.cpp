// Induced dipoles of unlike polarizabilities.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/short_range.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_unlike_dipoles_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using doctest::Approx;

namespace {

parallel::Team& alone = parallel::Team::single();
const std::vector<double> charge = {0.7, -0.4}, polarizability = {0.02, 0.11};

/// Two charges along x in a box so large that their nearest images are in free space.
SourceSet pair(double distance) {
  return {.lengths = {40, 40, 40}, .position = {10, 10, 10, 10 + distance, 10, 10}, .charge = charge};
}

Response solved(const SourceSet& sources, const std::vector<double>& each, std::vector<double>* dipoles = nullptr) {
  MinimumImage near;
  std::vector<double> dipole;
  Response response;
  InducedDipoles(near, DipoleSum::minimum_image, 0.11, 1e-14, each).evaluate(sources, {}, alone, dipole, response);
  if (dipoles) *dipoles = dipole;
  return response;
}

/// Two dipoles in line with the fields E_1 = -q_2/r^2 and E_2 = q_1/r^2 of the charges: mu_1 = A_1 (E_1 + 2 mu_2/r^3),
/// and the same with 1 and 2 exchanged. The energy is q_1 q_2/r - (mu_1 E_1 + mu_2 E_2)/2.
struct TwoDipoles {
  double first, second, energy;
};
TwoDipoles closed_form(double r) {
  const double e1 = -charge[1] / (r * r), e2 = charge[0] / (r * r), a = 2 / (r * r * r);
  const double determinant = 1 - polarizability[0] * polarizability[1] * a * a;
  const double first = polarizability[0] * (e1 + a * polarizability[1] * e2) / determinant;
  const double second = polarizability[1] * (e2 + a * polarizability[0] * e1) / determinant;
  return {first, second, charge[0] * charge[1] / r - 0.5 * (first * e1 + second * e2)};
}

}  // namespace

TEST_CASE("unlike induced dipoles: two in line have their closed form") {
  for (const double r : {0.8, 1.0, 3.0}) {
    CAPTURE(r);
    std::vector<double> dipole;
    const Response found = solved(pair(r), polarizability, &dipole);
    const TwoDipoles exact = closed_form(r);
    CHECK(dipole[0] == Approx(exact.first).epsilon(1e-12));
    CHECK(dipole[3] == Approx(exact.second).epsilon(1e-12));
    CHECK(found.energy == Approx(exact.energy).epsilon(1e-12));
    const double step = 1e-4, slope = (closed_form(r + step).energy - closed_form(r - step).energy) / (2 * step);
    CHECK(found.force[0] == Approx(slope).epsilon(1e-6));  // central difference: step^2 times the third derivative
    CHECK(std::abs(found.force[0] + found.force[3]) < 1e-14);
  }
}

TEST_CASE("unlike induced dipoles: forces are -dE/dx at general positions") {
  SourceSet sources = random_sources(6, {40, 40, 40}, 0, false, 3);
  for (double& x : sources.position) x = 18 + x / 10;
  const std::vector<double> each = {0.01, 0.02, 0.03, 0.05, 0.11, 0.001};
  const Response found = solved(sources, each);
  for (std::size_t k = 0; k < found.force.size(); ++k) {
    const double slope = energy_slope(sources.position[k], 1e-3, [&] { return solved(sources, each).energy; });
    CHECK(std::abs(slope + found.force[k]) < 1e-8);
  }
}

TEST_CASE("unlike induced dipoles: equal ones give the bits of one polarizability") {
  const SourceSet sources = pair(1.1);
  const Response one = solved(sources, {}), each = solved(sources, {0.11, 0.11});
  CHECK(one.energy == each.energy);
  CHECK(one.force == each.force);
}

// e_1 = 2 mu_2/r^3 and mu = A e: two dipoles in line diverge at r^6 = 4 A_1 A_2.
TEST_CASE("unlike induced dipoles: diverging ones are refused") {
  const double diverging = std::pow(4 * polarizability[0] * polarizability[1], 1.0 / 6);
  MinimumImage near;
  const InducedDipoles model(near, DipoleSum::minimum_image, 0.11, 1e-10, polarizability);
  CHECK(message_of([&] { model.check_stability(pair(1.001 * diverging), {}, alone); }).empty());
  CHECK(message_of([&] { model.check_stability(pair(0.999 * diverging), {}, alone); }).find("diverges") !=
        std::string::npos);
}

}  // namespace periodic_unlike_dipoles_test
