// Tests of the adhesion of grains: pull-off forces, energy of the contact, capture.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "src/model/rough_contact.hpp"
#include "tests/rough_grains.hpp"

namespace granular_adhesion_test {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using doctest::Approx;

namespace {

constexpr double modulus = 300, radius = 0.25, work = 0.5;

/// Surface energy (J/m^2) for a work of adhesion `w` (m0 v0^2 / d0^2) in the units of the scene.
double surface_energy(const Scene& scene, double w) {
  const auto [d0, m0, v0, q0] = *scene.reference;
  return 0.5 * w * m0 * v0 * v0 / (d0 * d0);
}

Scene adhesive(AdhesionModel model, double w, double elastic, double damping = 0) {
  Scene scene = cube(10);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = elastic, .dissipative = damping});
  scene.effects.add(effects::AdhesionOptions{.model = model, .surface_energy = surface_energy(scene, w)});
  return scene;
}

/// E of the viscoelastic contact of two grains of diameter 1 with the effective modulus E*: 4/3 E* sqrt(1/4).
double elastic_of(double effective_modulus) { return 2.0 / 3 * effective_modulus; }

/// Speed of separation after a head-on collision; 0 if the grains stick.
double rebound(Scene scene, double speed) {
  add_pair(scene, speed, 0.01);
  Run run(scene);
  while (run.gas.time() < 40 && (run.gas.collisions == 0 || !run.gas.contacts().empty()))
    run.step(run.gas.time() + 0.05);
  const Bodies& b = run.gas.bodies();
  return run.gas.contacts().empty() ? (velocity<3>(b, 1) - velocity<3>(b, 0)).x : 0;
}

}  // namespace

// Closed forms of Johnson, Kendall and Roberts 1971; the energy is 7.09 of Johnson and Pollock 1994.
TEST_CASE("JKR contact: force, pull-off and energy are those of the theory") {
  const JkrContact jkr(work, radius, modulus);
  const double unit = std::numbers::pi * work * radius;
  double smallest = 0, energy = 0;
  constexpr int n = 100'000;
  for (int k = 0; k <= n; ++k) {
    const double s = JkrContact::last + (1 - JkrContact::last) * k / n, a = jkr.radius_unit * s * s;
    const double overlap = a * a / radius - std::sqrt(2 * std::numbers::pi * work * a / modulus);
    const double force =
        4 * modulus * a * a * a / (3 * radius) - std::sqrt(8 * std::numbers::pi * work * modulus * a * a * a);
    if (k > 0) CHECK(jkr.root(overlap) == Approx(s).epsilon(1e-6));
    if (k % 1000 == 0) CHECK(jkr.force(s) == Approx(force).epsilon(1e-12).scale(unit));
    smallest = std::min(smallest, force);
    // Midpoint rule of the force over the overlap from the end of the contact to the overlap 0
    const double m = s + 0.5 * (1 - JkrContact::last) / n;
    if (k < n) energy -= jkr.force(m) * jkr.length * (4 * m * m * m - 1) * (1 - JkrContact::last) / n;
  }
  CHECK(smallest == Approx(-1.5 * unit).epsilon(1e-8));
  CHECK(jkr.pull_off() == Approx(1.5 * unit));
  CHECK(jkr.force(jkr.root(0)) == Approx(-4.0 / 3 * unit));
  CHECK(jkr.energy(JkrContact::last) == Approx(energy).epsilon(1e-8));
  CHECK(energy ==
        Approx(7.09 * std::cbrt(std::pow(work, 5) * std::pow(radius, 4) / (modulus * modulus))).epsilon(1e-3));
  CHECK(jkr.energy(1) == Approx(0));
}

TEST_CASE("DMT contact: the pull-off force is 2 pi w R") {
  const RoughContactLaw<ViscoelasticLaw> law{{elastic_of(modulus), 0}, {}, {AdhesionModel::dmt, work}};
  const RoughPair pair{1, 1, radius, 1};
  CHECK(law.normal_contact(pair, 1e-12, 0).force == Approx(-2 * std::numbers::pi * work * radius).epsilon(1e-6));
}

// Johnson and Pollock 1994; Thornton and Ning 1998: v_s = (14.18 / m_eff)^(1/2) (w^5 R^4 / E*^2)^(1/6). Faster grains
// lose the same energy.
TEST_CASE("JKR adhesion: elastic grains stick below the closed-form speed") {
  const Scene scene = adhesive(AdhesionModel::jkr, work, elastic_of(3000));
  const double sticking =
      std::sqrt(14.18 / 0.5) * std::pow(std::pow(work, 5) * std::pow(radius, 4) / (3000.0 * 3000), 1.0 / 6);
  CHECK(rebound(scene, 0.97 * sticking) == 0);
  CHECK(rebound(scene, 1.03 * sticking) > 0);
  for (const double factor : {1.2, 2.0})
    CHECK(rebound(scene, factor * sticking) == Approx(sticking * std::sqrt(factor * factor - 1)).epsilon(1e-2));
}

// Depth of the attraction: 0.6 * pull-off force * overlap at rest = 1.7e-4, of which damping takes a quarter. Grains of
// speed 0.005 have the energy 6e-6.
TEST_CASE("DMT adhesion: elastic grains rebound, damped slow ones stick") {
  CHECK(rebound(adhesive(AdhesionModel::dmt, 0.1, 2000), 0.5) == Approx(0.5).epsilon(2e-3));
  const Scene damped = adhesive(AdhesionModel::dmt, 0.1, 2000, 20);
  CHECK(rebound(damped, 0.005) == 0);
  CHECK(rebound(damped, 2) > 0.5);
}

// The error is of second order in the substep, pi/45 of an oscillation: 1/8 (pi/45)^2 = 6e-4 in each of some
// oscillations.
TEST_CASE("adhesion: the energy budget of captured grains is closed") {
  for (const AdhesionModel model : {AdhesionModel::dmt, AdhesionModel::jkr}) {
    CAPTURE(name_of(model));
    const auto error = [&](int steps) {
      Scene scene = adhesive(model, 0.1, 2000, 20);
      scene.mechanics.contact_steps = steps;
      add_pair(scene, 0.005, 0.001);
      Run run(scene);
      const double before = run.gas.energy().total();
      run.to(5);
      CHECK(run.gas.contacts().size() == 1);
      return std::abs(run.gas.energy().total() - before) / run.gas.energy().dissipated;
    };
    const double coarse = error(45), fine = error(90);
    CHECK(coarse < 5e-3);
    CHECK(fine < 0.4 * coarse);
  }
}

}  // namespace granular_adhesion_test
