// Tests of torus electrodes in space: chain of spheres, capacitance, refusals.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "solvers/laplace/spheres/spheres.hpp"
#include "tests/scene_texts.hpp"

namespace scene_torus_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

namespace {

/// Capacitance (F) of a torus in vacuum permittivity 1, by toroidal functions (Hicks 1881): with cosh eta = R / a,
/// C = 8 sqrt(R^2 - a^2) (Q_{-1/2} / P_{-1/2} + 2 sum_{n > 0} Q_{n - 1/2} / P_{n - 1/2}) (cosh eta). The functions are
/// periodic integrals, for which the trapezoidal rule converges exponentially.
double torus_capacitance(double radius, double wire_radius) {
  const double x = radius / wire_radius, root = std::sqrt(x * x - 1);
  constexpr int points = 2000;
  double sum = 0;
  for (int n = 0; n < 30; ++n) {
    double p = 0, q = 0;
    for (int k = 0; k < points; ++k) {
      const double t = 2 * std::numbers::pi * k / points;
      p += std::pow(x + root * std::cos(t), n - 0.5) / points;
      q += std::numbers::pi / std::sqrt(2.0) * std::cos(n * t) / std::sqrt(x - std::cos(t)) / points;
    }
    sum += (n == 0 ? 1 : 2) * q / p;
  }
  return 8 * wire_radius * root * sum;
}

std::string torus(const std::string& keys) {
  return "domain = { size = [0.04, 0.04, 0.01] }\nmedium = { relative_permittivity = 2.0 }\n"
         "effects.floating_conductors = {}\n[[electrode]]\nname = \"rim\"\nshape = \"torus\"\npotential = 0.0\n"
         "position = [0.02, 0.02, 0.004]\n" +
         keys;
}

}  // namespace

TEST_CASE("torus electrode: capacitance is that of a torus within 0.2 %") {
  // A thin wire has 4 pi^2 / ln(8 R / a), with an error of order (a / R)^2.
  const double thin = 4 * std::numbers::pi * std::numbers::pi / std::log(8 / 0.02);
  CHECK(torus_capacitance(1, 0.02) == doctest::Approx(thin).epsilon(1e-3));
  for (const double wire_radius : {0.125, 0.1, 0.045, 0.04}) {
    CAPTURE(wire_radius);
    const Scene scene = parse(torus("radius = 0.016\nwire_radius = " + std::to_string(0.016 * wire_radius) + "\n"));
    laplace::SphereProblem problem{
        .free_space = true, .permittivity = 1, .groups = {{.floating = false, .potential = 1}}};
    for (const Electrode& electrode : scene.electrodes)
      problem.spheres.push_back({electrode.centre() / 0.016, std::get<Disk>(electrode.shape).radius / 0.016, 0});
    double charge = 0;
    for (const double q : laplace::SphereSolver({.accuracy = 1e-4}).solve(problem).sphere_charge) charge += q;
    CHECK(charge == doctest::Approx(torus_capacitance(1, wire_radius)).epsilon(2e-3));
  }
}

TEST_CASE("torus electrode: its spheres form a closed chain around the z axis") {
  const Scene scene = parse(torus("radius = 0.016\nwire_radius = 0.001\n"));
  const std::size_t count = scene.electrodes.size();
  CHECK((count > 40 && count < 50));  // pi 16 / 1.134 = 44 spheres
  CHECK(scene.electrodes[0].name == "rim 1");
  for (std::size_t k = 0; k < count; ++k) {
    const Electrode &one = scene.electrodes[k], &next = scene.electrodes[(k + 1) % count];
    const double gap = norm(one.centre() - next.centre()) - 2 * std::get<Disk>(one.shape).radius;
    CHECK((gap > 0 && gap < 0.05 * 0.001));
    CHECK(one.height == 0.004);
    CHECK(norm(one.centre() - Vec3{0.02, 0.02, 0.004}) == doctest::Approx(0.016).epsilon(1e-12));
  }
}

TEST_CASE("torus electrode: wrong shape, size, place and resistor are refused") {
  check_refused(torus("radius = 0.016\nwire_radius = 0.003\n"), {"electrode.wire_radius = 0.003", "0.002 m"});
  check_refused(torus("radius = 0.016\n"), {"electrode.wire_radius is missing"});
  check_refused(torus("radius = 0.0195\nwire_radius = 0.001\n"), {"this torus is on or through a side of the domain"});
  check_refused(torus("radius = 0.016\nwire_radius = 0.001\nseries_resistance = 1e9\n"),
                {"an electrode with shape = \"torus\" consists of separate spheres"});
  std::string floating = torus("radius = 0.016\nwire_radius = 0.001\ncharge = 1e-12\n");
  floating.erase(floating.find("potential = 0.0\n"), 16);
  check_refused(floating, {"separate spheres", "a charge and a circuit are not allowed"});
  check_refused(torus("radius = 0.016\nwire_radius = 0.001\n") +
                    "[[electrode]]\nname = \"rim 2\"\nshape = \"sphere\"\nposition = [0.02, 0.02, 0.004]\n"
                    "radius = 0.001\npotential = 0.0\n",
                {"electrode.name = \"rim 2\" is taken"});
  check_refused(box + electrostatics +
                    "[[electrode]]\nshape = \"torus\"\nposition = [0.02, 0.01]\nradius = 0.005\nwire_radius = 0.0005\n"
                    "potential = 0.0\n",
                {"electrode.shape = \"torus\" is not allowed in two dimensions"});
}

}  // namespace scene_torus_test
