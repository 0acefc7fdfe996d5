#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "tests/message.hpp"

namespace spheres_ratios_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

constexpr double four_pi = 4 * std::numbers::pi;

/// Digamma function by its recurrence and asymptotic series.
double digamma(double x) {
  double sum = 0;
  for (; x < 20; ++x) sum -= 1 / x;
  const double y = 1 / (x * x);
  return sum + std::log(x) - 0.5 / x - y * (1.0 / 12 - y * (1.0 / 120 - y / 252));
}

/// Charges on a line.
struct Images {
  std::vector<double> position, charge;
  double sum() const {
    double total = 0;
    for (const double q : charge) total += q;
    return total;
  }
};

/// Image charges of two spheres of radii a at 0 and b at d with charges qa and qb, in units of 4 pi eps. Solutions with
/// one sphere at a potential and the other at 0 are superposed.
std::array<Images, 2> images_of(double a, double b, double d, double qa, double qb) {
  std::array<std::array<Images, 2>, 2> unit;  // [sphere at a potential][sphere].
  for (const int held : {0, 1}) {
    const std::array radius = {a, b}, centre = {0.0, d};
    double charge = radius[held], position = centre[held];
    for (int on = held, count = 0; count < 400; ++count) {
      unit[held][on].position.push_back(position), unit[held][on].charge.push_back(charge);
      on = 1 - on;
      const double away = position - centre[on];
      charge *= -radius[on] / std::abs(away);
      position = centre[on] + radius[on] * radius[on] / away;
    }
  }
  const double aa = unit[0][0].sum(), ab = unit[1][0].sum(), ba = unit[0][1].sum(), bb = unit[1][1].sum();
  const double determinant = aa * bb - ab * ba;
  const std::array potential = {(qa * bb - ab * qb) / determinant, (aa * qb - ba * qa) / determinant};
  std::array<Images, 2> both;
  for (const int on : {0, 1})
    for (const int held : {0, 1})
      for (std::size_t k = 0; k < unit[held][on].position.size(); ++k) {
        both[on].position.push_back(unit[held][on].position[k]);
        both[on].charge.push_back(potential[held] * unit[held][on].charge[k]);
      }
  return both;
}

/// Force on the second sphere for 4 pi eps = 1, with charges in units of it.
double force_between(const std::array<Images, 2>& images) {
  double force = 0;
  for (std::size_t i = 0; i < images[0].position.size(); ++i)
    for (std::size_t j = 0; j < images[1].position.size(); ++j) {
      const double separation = images[1].position[j] - images[0].position[i];
      force += images[0].charge[i] * images[1].charge[j] / (separation * std::abs(separation));
    }
  return force;
}

/// Problem of a large sphere of radius 1 at the origin and a small one of radius r, 4 pi eps = 1, in an oblique
/// direction.
SphereProblem near_large_sphere(double r, double gap, bool one_group) {
  SphereProblem problem{.free_space = true, .permittivity = 1 / four_pi};
  const Vec3 direction = Vec3{2, -1, 2} * (1.0 / 3);
  problem.spheres = {{{}, 1, 0}, {direction * (1 + r + gap), r, one_group ? 0 : 1}};
  problem.groups = {{.charge = 1}};
  if (!one_group) problem.groups.push_back({.charge = 0.3 * r});
  return problem;
}

}  // namespace

TEST_CASE("touching spheres, radius ratio of 100: charges are Maxwell's") {
  const double r = 0.01;
  for (const double accuracy : {1e-2, 1e-4, 1e-7}) {
    CAPTURE(accuracy);
    const SphereSolution found = SphereSolver({.accuracy = accuracy}).solve(near_large_sphere(r, 0, true));
    const double small = -r / (1 + r) * (std::numbers::egamma + digamma(1 / (1 + r)));
    const double large = -r / (1 + r) * (std::numbers::egamma + digamma(r / (1 + r)));
    CHECK(found.group_potential[0] == doctest::Approx(1 / (small + large)).epsilon(accuracy));
    // Relative to the small charge, 1.6e-4 of the large one.
    CHECK(found.sphere_charge[1] == doctest::Approx(small / (small + large)).epsilon(accuracy));
    CHECK(found.degree < 200);
  }
}

TEST_CASE("separate spheres, radius ratio of 100: force is that of image charges") {
  const double r = 0.01;
  for (const double gap : {3 * r, r, 0.1 * r}) {
    const double force = force_between(images_of(1, r, 1 + r + gap, 1, 0.3 * r));
    for (const double accuracy : {1e-3, 1e-4, 1e-8}) {
      CAPTURE(gap);
      CAPTURE(accuracy);
      const SphereProblem problem = near_large_sphere(r, gap, false);
      const auto solver_for = [](double tolerance) { return SphereSolver({.accuracy = tolerance}); };
      const SphereSolution found = solve_to_accuracy(problem, accuracy, solver_for).solution;
      const Vec3 direction = problem.spheres[1].centre * (1 / norm(problem.spheres[1].centre));
      CHECK(norm(found.sphere_force[1] - direction * force) < accuracy * std::abs(force));
      CHECK(norm(found.sphere_force[0] + direction * force) < accuracy * std::abs(force));
    }
  }
}

TEST_CASE("spheres of different radii in a box: forces are energy derivatives") {
  const auto energy_of = [](int moved, Vec3 by) {
    SphereProblem problem{.permittivity = 1};
    problem.box.lengths = {3, 3, 3};
    problem.box.sides[4] = Boundary::electrode;
    problem.spheres = {{{1.4, 1.5, 1.3}, 1, 0}, {{1.4, 2.54, 1.7}, 0.05, 1}, {{2.6, 0.3, 2.5}, 0.2, 2}};
    problem.groups = {{.charge = 1}, {.charge = -0.1}, {.charge = 0.4}};
    problem.spheres[moved].centre += by;
    return SphereSolver({.accuracy = 1e-10}).solve(problem);
  };
  constexpr double step = 1e-4;
  const SphereSolution found = energy_of(0, {});
  CHECK(found.degree <= 200);
  for (const int moved : {0, 1})
    for (const Vec3 along : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
      const double slope =
          (energy_of(moved, along * step).energy - energy_of(moved, along * -step).energy) / (2 * step);
      // The differences are of second order in the step over the gap of 1/15.
      CHECK(std::abs(dot(found.sphere_force[moved], along) + slope) < 1e-4 * norm(found.sphere_force[moved]));
    }
}

TEST_CASE("spheres of different radii: harmonics and image reflections agree") {
  // The gap is one small radius, 1/20 of the large one: it needs degree 167 for 1e-6, and more than 200 for 1e-8.
  SphereProblem problem = near_large_sphere(0.05, 0.05, false);
  const SphereSolution all = SphereSolver({.accuracy = 1e-6}).solve(problem);
  const SphereSolution reflected = SphereSolver({.accuracy = 1e-8}).solve(problem);
  CHECK(all.degree > 100);
  CHECK(reflected.degree < 100);
  for (const int i : {0, 1}) {
    CHECK(norm(all.sphere_force[i] - reflected.sphere_force[i]) < 1e-6 * norm(all.sphere_force[0]));
    CHECK(all.group_potential[i] == doctest::Approx(reflected.group_potential[i]).epsilon(1e-6));
  }
}

TEST_CASE("sphere radius ratio out of reach: refused, names an accuracy if possible") {
  // Two small spheres whose images in the large one interact.
  SphereProblem problem = near_large_sphere(0.01, 0, true);
  const Vec3 next = Vec3{2, -1, 2.1} * (1.01 / norm(Vec3{2, -1, 2.1}));
  problem.spheres.push_back({next, 0.01, 0});
  const auto refusal = [&](double accuracy) -> std::string {
    return message_of<InputError>([&] { SphereSolver({.accuracy = accuracy}).forecast(problem); });
  };
  const std::string sentence = refusal(1e-6);
  REQUIRE(sentence.find("suffices for field.accuracy = ") != std::string::npos);
  CHECK(refusal(std::stod(sentence.substr(sentence.find("accuracy = ") + 11))) == "");
  problem.spheres.pop_back();
  problem.spheres[1] = {{1 + 1e-5, 0, 0}, 1e-5, 0};
  CHECK(refusal(1e-3).find("suffices for no field.accuracy") != std::string::npos);
}

}  // namespace spheres_ratios_test
