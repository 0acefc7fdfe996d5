// Law of charge sharing added from outside whose conductance decreases exponentially with the gap, as for tunnelling.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/gravity.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/scene/effect_kind.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

namespace extend_gap_law {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using effects::Contact, effects::ContactState, effects::SharingLaw;

namespace {

struct TunnelOptions {
  double conductance = 0, decay = 0, gap_scale = 0;  ///< S at gap 0; m; m
  static const EffectKind& kind();
};

struct Tunnel : Effect {
  const EffectKind& kind() const override { return TunnelOptions::kind(); }
};

const EffectKind& TunnelOptions::kind() {
  static const EffectKind kind = {.name = "tunnel",
                                  .description = "the conductance of a contact falls exponentially with its gap",
                                  .options = TunnelOptions{},
                                  .make = [](const Scene&) { return std::make_unique<Tunnel>(); },
                                  .sharing = [](const Scene& scene, Contact) -> SharingLaw {
                                    const TunnelOptions options = *scene.effects.find<TunnelOptions>();
                                    return {.conductance_in_state =
                                                [options](const ContactState& state) {
                                                  return options.conductance * std::exp(-state.gap() / options.decay);
                                                },
                                            .gap_scale = options.gap_scale};
                                  }};
  return kind;
}

constexpr double speed = 1, closest = 2.1 * radius, decay = 0.05 * radius;  // m/s, m, m
constexpr double conductance = 3e-9;  // In S: about 60 % of the difference is transferred.

/// Conductor 1 passes conductor 0, which is fixed, on a straight line from `start` to -start along x.
struct Passage {
  double start = 0, velocity = 0, acceleration = 0;  ///< In m, m/s, m/s^2; one of the last two is 0.

  // In s.
  double end() const { return acceleration > 0 ? std::sqrt(-4 * start / acceleration) : -2 * start / velocity; }
  double gap(double t) const {
    return std::hypot(closest, start + velocity * t + 0.5 * acceleration * t * t) - 2 * radius;
  }
};

/// Exponent of the decay of the charge difference, the integral of G(gap) ln(d/R) / (pi epsilon depth) over a passage.
/// LineCharges gives two charges the potential difference (q1 - q2) ln(d/R) / (2 pi epsilon depth).
double exponent(const Passage& passage) {
  double sum = 0;
  const int steps = 100000;
  const double dt = passage.end() / steps;
  for (int k = 0; k < steps; ++k) {
    const double gap = passage.gap((k + 0.5) * dt);
    sum += dt * conductance * std::exp(-gap / decay) * std::log((gap + 2 * radius) / radius);
  }
  return sum / (std::numbers::pi * 4.2e-11 * 2 * radius);
}

ConductorFrame after(const Passage& passage, double gap_scale) {
  Scene scene = conductor_scene({{0.05, 0.05}, {0.05 + passage.start, 0.05 + closest}});
  scene.conductors[0].fixed = true;
  scene.conductors[1].velocity = {passage.velocity, 0};
  scene.conductors[0].charge = 1e-12;
  scene.conductors[1].charge = -1e-12;
  scene.material.density = 1e15;  // The field and drag do not move it.
  scene.mechanics.position_tolerance = 1e-5 * radius;
  scene.effects.add(TunnelOptions{.conductance = conductance, .decay = decay, .gap_scale = gap_scale});
  scene.effects.add(effects::GravityOptions{.acceleration = passage.acceleration, .direction = Coordinates{{1, 0}}});
  Simulation simulation(scene, std::make_unique<LineCharges>());
  simulation.advance_to(passage.end());
  return simulation.now();
}

/// From outside the contact's gap, and from rest within it.
constexpr Passage flight{.start = -4 * radius, .velocity = speed};
constexpr Passage fall{.start = -2 * radius, .acceleration = speed * speed / (4 * radius)};

}  // namespace

TEST_CASE("user-defined gap conductance: charge of a fast passage right within 1e-3") {
  for (const Passage& passage : {flight, fall}) {
    const ConductorFrame frame = after(passage, decay);
    const double left = (frame.charge[0] - frame.charge[1]) / 2e-12;
    REQUIRE(exponent(passage) > 0.5);
    // Each step may have an error of position_tolerance / radius of the charge: some hundred steps.
    CHECK(std::abs(left - std::exp(-exponent(passage))) < 1e-3);
    CHECK(frame.charge_held == 0);
  }
}

TEST_CASE("user-defined gap conductance: needs a finite positive gap_scale") {
  CHECK_THROWS_WITH_AS(after(flight, INFINITY), doctest::Contains("must state its gap_scale"), InputError);
  CHECK_THROWS_WITH_AS(after(flight, 0), doctest::Contains("a gap_scale of 0 m: it must be > 0"), InputError);
}

}  // namespace extend_gap_law
