#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/linear_spring.hpp"
#include "src/model/pair_loop.hpp"
#include "src/model/viscoelastic.hpp"

namespace effects_contact_laws_test {

using namespace lichtenberg;
using namespace lichtenberg::effects;
using doctest::Approx;

namespace {

const ViscoelasticLaw viscoelastic{278.6, 27.7};
const LinearSpringLaw linear{278.6, 10};
constexpr double half = 0.5;  // Effective mass of two grains of mass 1.

struct Collision {
  double restitution = 0, duration = 0;  ///< Duration of the force.
  double dissipated = 0;
};

/// Collision of two grains at the given speed by a fourth-order Runge-Kutta method in sqrt(t), in which sqrt(overlap)
/// is smooth. At the non-attractive cut-off the acceleration (slope 600) has a kink in a step of about 2e-5: an error
/// of 1e-7.
template <class Law>
Collision collide(const Law& law, double speed) {
  using State = std::array<double, 3>;  // Overlap, approach speed, dissipated energy.
  const auto rate = [&](double sigma, const State& y) {
    const ContactForce contact = contact_at(law, y[0], y[1]);
    return State{2 * sigma * y[1], -2 * sigma * contact.force / half, 2 * sigma * contact.dissipated};
  };
  const auto moved = [](const State& y, double h, const State& k) {
    return State{y[0] + h * k[0], y[1] + h * k[1], y[2] + h * k[2]};
  };
  State y = {1e-14, speed, 0};
  const double h = 2e-5;
  double duration = 0;
  for (int n = 0; y[0] > 0; ++n) {
    const double s = n * h;
    const State a = rate(s, y), b = rate(s + h / 2, moved(y, h / 2, a)), c = rate(s + h / 2, moved(y, h / 2, b)),
                d = rate(s + h, moved(y, h, c));
    for (int k = 0; k < 3; ++k) y[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
    if (contact_at(law, y[0], y[1]).force > 0) duration = (s + h) * (s + h);
  }
  return {-y[1] / speed, duration, y[2]};
}

template <class Law>
void check_derivatives(const Law& law, double overlap, double closing, double scale) {
  const ContactForce here = contact_at(law, overlap, closing, scale);
  const auto elastic = [&](double at) { return contact_at(law, at, 0, scale); };
  const double h = 1e-6;  // Truncation h^2 f'''/6 < 1e-8, rounding 1e-14 / h.
  CHECK(law.parts(overlap, scale).elastic_slope ==
        Approx((elastic(overlap + h).force - elastic(overlap - h).force) / (2 * h)).epsilon(1e-7));
  CHECK(elastic(overlap).force ==
        Approx((law.parts(overlap + h, scale).stored - law.parts(overlap - h, scale).stored) / (2 * h)).epsilon(1e-7));
  CHECK(here.dissipated == Approx((here.force - elastic(overlap).force) * closing).epsilon(1e-13));
}

}  // namespace

TEST_CASE("contact laws: slope, stored energy and dissipation match the force") {
  for (const double closing : {-5.0, -0.1, 0.0, 0.7, 3.0})
    for (const double scale : {1.0, 0.7}) {
      check_derivatives(viscoelastic, 0.08, closing, scale);
      check_derivatives(linear, 0.08, closing, scale);
    }
}

TEST_CASE("contact laws: never attract; the remaining spring energy is dissipated") {
  // E xi = 0.04 * 278.6 = 11.1 < D |xi'|, and A xi = 11.1 < B |xi'| = 20.
  const ContactForce soft = contact_at(viscoelastic, 0.04, -2), spring = contact_at(linear, 0.04, -2);
  CHECK(soft.force == 0);
  CHECK(soft.dissipated == Approx(278.6 * 0.008 * 2));
  CHECK(viscoelastic.parts(0.04).stored == Approx(0.4 * 278.6 * 0.04 * 0.008));
  CHECK(spring.force == 0);
  CHECK(spring.dissipated == Approx(278.6 * 0.04 * 2));
  for (const double overlap : {0.0, -0.1}) {
    CHECK(contact_at(viscoelastic, overlap, 3).force == 0);
    CHECK(contact_at(linear, overlap, 3).force == 0);
  }
}

TEST_CASE("viscoelastic law without damping: Hertz's force for spheres of any radii") {
  // E of two grains of diameter 1 is 4/3 E* sqrt(1/4).
  const ViscoelasticLaw elastic{278.6, 0};
  for (const double radius : {0.5, 0.2, 3.0}) {
    const PairGeometry pair{.distance = 0.45 + radius, .reach = 0.5 + radius, .radius_i = 0.5, .radius_j = radius};
    const PairForce hertzian = HertzLaw{1.5 * 278.6}(pair);
    const ContactParts here = elastic.parts(pair.reach - pair.distance, elastic.scale(0.5, radius));
    CHECK(here.elastic == Approx(hertzian.force).epsilon(1e-13).scale(0));
    CHECK(here.stored == Approx(hertzian.energy).epsilon(1e-13).scale(0));
    CHECK(here.elastic_slope == Approx(hertzian.stiffness).epsilon(1e-13).scale(0));
  }
  CHECK(elastic.scale(0.5, 0.5) == 1);
}

TEST_CASE("collision: kinetic energy lost equals energy dissipated in the contact") {
  for (const Collision& collision :
       {collide(viscoelastic, 1), collide(linear, 1), collide(LinearSpringLaw{278.6, 27.7}, 1)})
    CHECK(half * half * (1 - collision.restitution * collision.restitution) ==
          Approx(collision.dissipated).epsilon(1e-6).scale(0));
}

TEST_CASE("viscoelastic grains: restitution and duration, E = 278.6, D = 27.7") {
  // To the digits of an independent solution of the same equation.
  CHECK(collide(viscoelastic, 1).restitution == Approx(0.330835).epsilon(2e-6).scale(0));
  CHECK(collide(viscoelastic, 0.01).restitution == Approx(0.597185).epsilon(2e-6).scale(0));
  CHECK(collide(viscoelastic, 1).duration == Approx(0.213).epsilon(3e-3).scale(0));
}

TEST_CASE("linear spring law: restitution and duration equal the closed form") {
  // A = 278.6, and z = 1 at B = 2 sqrt(A / 2) = 23.6: both branches. Digits of a numerical solution.
  const double known[][2] = {{1, .8784330594}, {10, .3464297011}, {20, .1675527592}, {27.7, .1086084758}};
  for (const auto& [damping, restitution] : known) {
    CHECK(LinearSpringLaw{278.6, damping}.collision(half).restitution == Approx(restitution).epsilon(1e-9).scale(0));
    CHECK(linear_damping(278.6, restitution, half) == Approx(damping).epsilon(1e-9).scale(0));
  }
  for (const double damping : {10.0, 27.7}) {
    const HeadOnCollision theory = LinearSpringLaw{278.6, damping}.collision(half);
    const Collision measured = collide(LinearSpringLaw{278.6, damping}, 2);
    CHECK(measured.restitution == Approx(theory.restitution).epsilon(1e-6).scale(0));
    CHECK(measured.duration == Approx(theory.duration).epsilon(3e-4).scale(0));  // One step is 1e-5.
  }
  const double critical = 2 * std::sqrt(278.6 / 2);
  CHECK(LinearSpringLaw{278.6, critical}.collision(half).restitution == Approx(std::exp(-2)).epsilon(1e-9).scale(0));
  CHECK(linear_damping(278.6, 1, half) == 0);
  for (const double refused : {0.0, -0.1, 1.1, std::nan("")})
    CHECK_THROWS_AS(linear_damping(278.6, refused, half), InputError);
}

}  // namespace effects_contact_laws_test
