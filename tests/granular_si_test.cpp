// Scenes of grains in SI: reduced units that the program chooses, and results against closed forms in SI.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/uniform_field.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/model/frame.hpp"
#include "src/scene/si.hpp"
#include "tests/message.hpp"

namespace granular_si_test {

using namespace lichtenberg;
using doctest::Approx;

namespace {

constexpr double radius = 50e-6, density = 2500, young = 70e9, poisson = 0.22;  // glass beads
constexpr double bead = density * 4.0 / 3 * std::numbers::pi * radius * radius * radius;
constexpr double coulomb_constant = 1 / (4 * std::numbers::pi * 8.8541878128e-12);

const std::string dust =
    "[domain]\nsize = [2e-3, 2e-3, 2e-3]\nunbounded = true\n[material]\ndensity = 2500\n"
    "[mechanics]\nintegrator = \"cvode\"\n[stop]\ntime = 1.0\n";
const std::string glass = "[effects.viscoelastic_contact]\nyoung = 70e9\npoisson = 0.22\nviscosity = 0\n";

std::string grain(const std::string& position, const std::string& more) {
  return "[[conductor]]\nradius = 50e-6\nposition = " + position + "\n" + more + "\n";
}

Scene parse(const std::string& text) { return parse_scene(text, "dust.toml"); }

/// Returns a column of the last frame in SI. `unit`: reduced unit in SI.
std::vector<double> column(GranularMotion& motion, const std::string& name, double unit) {
  std::vector<double> values = motion.frame().reals(name);
  for (double& value : values) value *= unit;
  return values;
}

/// A run of a scene in SI up to a time in s.
struct RunInSi {
  explicit RunInSi(const std::string& text) : scene(parse(text)), units(*scene.reference), motion(scene) {}

  void to(double seconds) { motion.advance_to(seconds * units.velocity / units.length, {}); }
  /// Distance (m) along x of the first two grains.
  double distance() {
    const std::vector<double> position = column(motion, "position", units.length);
    return position[3] - position[0];
  }

  Scene scene;
  Reference units;
  GranularMotion motion;
};

}  // namespace

TEST_CASE("scene in SI: units follow from its largest grain, speed and charge") {
  const Scene scene = parse(dust + glass + "[effects.coulomb]\n" +
                            grain("[1e-3, 1e-3, 1e-3]", "charge = \"1000 e\"\nvelocity = [0.02, 0, 0]") +
                            grain("[1.5e-3, 1e-3, 1e-3]", "charge = -1e-17"));
  REQUIRE(scene.in_si);
  const Reference units = *scene.reference;
  CHECK(units.length == Approx(2 * radius).epsilon(1e-15));
  CHECK(units.mass == Approx(bead).epsilon(1e-14));
  CHECK(units.velocity == 0.02);
  CHECK(units.charge == 1000 * 1.602176634e-19);
  CHECK(scene.conductors[0].radius == 0.5);
  CHECK(scene.conductors[0].velocity.x == 1);
  CHECK(scene.conductors[1].position.x == Approx(15).epsilon(1e-14));
  CHECK(scene.material.density == Approx(6 / std::numbers::pi).epsilon(1e-14));
  CHECK(scene.stop.time == Approx(200).epsilon(1e-14));  // t0 = 5 ms
  CHECK(scene.effects.find<effects::CoulombOptions>()->strength ==
        Approx(coulomb_constant * units.charge * units.charge / (bead * 0.02 * 0.02 * 1e-4)).epsilon(1e-14));
}

TEST_CASE("scene in SI: keys of effects are converted by their units") {
  const Scene scene = parse(dust + grain("[1e-3, 1e-3, 1e-3]", "velocity = [0.5, 0, 0]\ncharge = 2e-15") +
                            "[effects.linear_contact]\nstiffness = 100\n[effects.gas_drag]\nstokes = 3\nspeed = 0.1\n"
                            "correlation_time = 0.2\n[effects.uniform_field]\nfield = [0, 0, 1e4]\n"
                            "[effects.charge_exchange]\nmodel = \"random-walk\"\ntransfer_prefactor = \"25 e\"\nrate = "
                            "1e6\ncapacity = 4e-15\n");
  const Reference units = *scene.reference;
  const double t0 = units.length / units.velocity;
  CHECK(scene.effects.find<effects::LinearContactOptions>()->stiffness == Approx(100 * t0 * t0 / units.mass));
  const auto& drag = *scene.effects.find<effects::GasDragOptions>();
  CHECK(drag.stokes == Approx(3 * t0));
  CHECK(drag.speed == Approx(0.2));
  CHECK(drag.correlation_time == Approx(0.2 / t0));
  const double field = units.mass * units.velocity * units.velocity / (units.charge * units.length);
  CHECK(scene.effects.find<effects::UniformFieldOptions>()->field.value.z == Approx(1e4 / field));
  const auto& exchange = *scene.effects.find<effects::ChargeExchangeOptions>();
  CHECK(exchange.strength == Approx(25 * elementary_charge / units.charge));
  CHECK(exchange.rate == Approx(1e6 * t0));
  CHECK(exchange.capacity == Approx(4e-15 / units.charge));
}

TEST_CASE("scene in SI: a bead falls by g t^2 / 2") {
  RunInSi run(dust + glass + "[effects.uniform_force]\nacceleration = [0, 0, -9.81]\n" +
              grain("[1e-3, 1e-3, 1e-3]", "velocity = [0, 0, 0.1]"));
  run.to(0.05);
  const std::vector<double> position = column(run.motion, "position", run.units.length);
  CHECK(position[2] == Approx(1e-3 + 0.1 * 0.05 - 9.81 * 0.05 * 0.05 / 2).epsilon(1e-10));
}

// Without damping the overlap x of two beads has m_eff x'^2 / 2 + 2/5 k x^(5/2) = m_eff u^2 / 2, with k = 4/3 E*
// sqrt(R*). Hence x is at most (5 m_eff u^2 / (4 k))^(2/5), and the contact lasts 4/5 sqrt(pi) Gamma(2/5) / Gamma(9/10)
// x / u.
TEST_CASE("scene in SI: a collision has Hertz's duration and overlap") {
  const double u = 0.02, gap = 1e-6;
  RunInSi run(dust + glass + grain("[1e-3, 1e-3, 1e-3]", "velocity = [0.01, 0, 0]") +
              grain("[1.101e-3, 1e-3, 1e-3]", "velocity = [-0.01, 0, 0]"));
  const double stiffness = 4.0 / 3 * young / (2 * (1 - poisson * poisson)) * std::sqrt(radius / 2);
  const double overlap = std::pow(5 * bead / 2 * u * u / (4 * stiffness), 0.4);
  const double duration = 0.8 * std::sqrt(std::numbers::pi) * std::tgamma(0.4) / std::tgamma(0.9) * overlap / u;
  CHECK(overlap == Approx(15.7e-9).epsilon(0.3));
  const double onset = gap / u;
  run.to(onset + duration / 2);
  // A position of 1.1 mm is rounded by 2e-19 m, and cvode's error is 1e-13 of 11 d0: 1e-16 m.
  CHECK(2 * radius - run.distance() == Approx(overlap).epsilon(1e-6));
  const double end = onset + 10 * duration;
  run.to(end);
  CHECK(end - onset - (run.distance() - 2 * radius) / u == Approx(duration).epsilon(1e-6));
}

TEST_CASE("scene in SI: Coulomb's force of two charges in newtons") {
  RunInSi run(dust + glass + "[effects.coulomb]\n" + grain("[1e-3, 1e-3, 1e-3]", "charge = \"1e5 e\"") +
              grain("[1.3e-3, 1e-3, 1e-3]", "charge = \"-5e4 e\""));
  const double unit = run.units.mass * run.units.velocity * run.units.velocity / run.units.length;
  const std::vector<double> force = column(run.motion, "coulomb_force", unit);
  const double e = 1.602176634e-19, r = 3e-4;
  CHECK(force[0] == Approx(coulomb_constant * 5e9 * e * e / (r * r)).epsilon(1e-12));
}

TEST_CASE("velocity_spread: is the rms of each component, by mass") {
  for (const char* units : {"", "[units]\n"}) {
    CAPTURE(units);
    const bool si = std::string(units).empty();
    const Scene scene = parse(std::string(units) +
                              (si ? dust + glass
                                  : "[domain]\nsize = [40, 40, 40]\nunbounded = true\n"
                                    "[effects.viscoelastic_contact]\n") +
                              fmt::format("[[population]]\ncount = 60\nradius = [{0}, {1}]\nvelocity_spread = 0.03\n",
                                          si ? 20e-6 : 0.2, si ? 50e-6 : 0.5));
    double mass = 0, energy = 0;
    for (const Conductor& c : scene.conductors) {
      const double m = c.radius * c.radius * c.radius;
      mass += m, energy += m * dot(c.velocity, c.velocity);
    }
    const double unit = si ? scene.reference->velocity : 1;
    CHECK(std::sqrt(energy / mass / 3) * unit == Approx(0.03).epsilon(1e-12));
  }
}

TEST_CASE("scene in SI: speed, field or charges at rest give the unit of velocity") {
  const std::string rest = dust + glass + grain("[1e-3, 1e-3, 1e-3]", "charge = 1e-15");
  const auto speed = [](const std::string& text) { return parse(text).reference->velocity; };
  CHECK(speed(dust + glass + grain("[1e-3, 1e-3, 1e-3]", "")) == 1);
  CHECK(speed(dust + glass + grain("[1e-3, 1e-3, 1e-3]", "") +
              "[effects.uniform_force]\nacceleration = [0, 0, -9.81]\n") == Approx(std::sqrt(9.81 * 1e-4)));
  CHECK(speed(rest) == Approx(std::sqrt(coulomb_constant * 1e-30 / (bead * 1e-4))));
  CHECK(speed(rest + "[effects.uniform_field]\nfield = [0, 0, 1e6]\n") == Approx(std::sqrt(1e-9 * 1e-4 / bead)));
}

TEST_CASE("scene in SI: missing keys and keys in reduced units are refused") {
  struct Refused {
    std::string text, sentence;
  };
  const std::string one = grain("[1e-3, 1e-3, 1e-3]", "");
  const std::string force = dust + glass + one;
  const std::vector<Refused> table = {
      {"[domain]\nsize = [1, 1, 1]\nunbounded = true\n" + glass + one,
       "material.density is missing: a scene of grains"},
      {"[domain]\nsize = [1, 1, 1]\nunbounded = true\n[material]\ndensity = 2500\n" + glass + one,
       "stop.time is missing: a scene of grains"},
      {dust + glass + "[[population]]\ncount = 3\n", "population.radius is missing: a scene of grains"},
      {dust + one + "[effects.viscoelastic_contact]\n", "young is missing"},
      {dust + one + "[effects.viscoelastic_contact]\nstiffness = 200\n",
       "effects.viscoelastic_contact.stiffness is not allowed without [units]"},
      {force + "[effects.coulomb]\ncoupling_constant = 2\n",
       "effects.coulomb.coupling_constant is not allowed without [units]"},
      {dust + one + "[effects.linear_contact]\n", "effects.linear_contact.stiffness is missing"},
      {force + "[effects.gas_drag]\n", "effects.gas_drag.stokes is missing"},
      {force + "[effects.gas_drag]\nstokes = 1\nspeed = 1\n", "effects.gas_drag.correlation_time is missing"},
      {force + "[effects.coulomb]\n[effects.induced_dipoles]\n", "effects.induced_dipoles.polarizability is missing"},
      {force + "[effects.charge_exchange]\n", "effects.charge_exchange.transfer_prefactor is missing"},
      {force + "[effects.charge_exchange]\nmodel = \"random-walk\"\ntransfer_prefactor = 1e-15\n",
       "effects.charge_exchange.rate is missing"},
      {force + "[effects.uniform_field]\nfield = [0, 0, 1]\n[effects.charge_exchange]\nmodel = \"polarization\"\n"
               "transfer_prefactor = 1e-15\n",
       "effects.charge_exchange.field is missing"},
      {force + "[medium]\nviscosity = 1\n", "[medium] is not allowed in a scene of grains"},
      {dust + glass + grain("[1e-3, 1e-3, 1e-3]", "charge = \"12 C\""),
       "conductor.charge = \"12 C\" has the wrong unit"},
      {dust + glass + grain("[1e-3, 1e-3, 1e-3]", "charge = \"nan e\""),
       "dust.toml:17: conductor.charge = \"nan e\" is not allowed: it must be"},
      {force + "[effects.charge_exchange]\nmodel = \"material\"\ntransfer_prefactor = 1e-15\n",
       "effects.charge_exchange.affinities is missing: model = \"material\" needs one for each"},
      {dust + glass + grain("[1e-3, 1e-3, 1e-3]", "charge = \"1000e\""), "has the wrong unit or type"},
      {"[units]\n[domain]\nsize = [9, 9, 9]\nunbounded = true\n[effects.viscoelastic_contact]\n" +
           grain("[5, 5, 5]", "charge = \"3 e\""),
       "conductor.charge = \"3 e\" has the wrong unit or type"},
      {dust + glass + "[[population]]\ncount = 3\nradius = 5e-5\ntemperature = 1e-15\nvelocity_spread = 0.1\n",
       "population.temperature and population.velocity_spread are both given"},
      {"[domain]\nsize = [2e-3, 2e-3]\n" + glass + grain("[1e-3, 1e-3]", "") + "[effects.stokes_drag]\n",
       "effects.stokes_drag is for scenes of conductors, and effects.viscoelastic_contact for scenes of grains"},
      {force + "[effects.gravity]\n", "leave one of them out; effects.uniform_force gives grains a weight"},
      {dust + glass + "[effects.hertz_contact]\n" + grain("[1e-3, 1e-3, 1e-3]", "charge = \"1e5 e\""),
       "dust.toml:14: effects.hertz_contact is for scenes of conductors"},
  };
  for (const auto& [text, sentence] : table) {
    CAPTURE(text);
    const std::string found = message_of([&] { parse(text); });
    CHECK_MESSAGE(found.find(sentence) != std::string::npos, found);
    CHECK(found.find('\n') == std::string::npos);
  }
}

TEST_CASE("keys of grains: the unit of each is that of a scene in SI") {
  const Reference units;
  for (const EffectKind* kind : effects::all_kinds())
    for (const Key& key : kind->keys)
      if (kind->grains && key.scale == Key::Scale::own && !key.unit.empty()) {
        CAPTURE(kind->name + "." + key.name);
        CHECK(reduced_unit(key.unit, units));
      }
  CHECK(*reduced_unit("m0 v0^2/(q0 d0)", units) == Approx(1.52e-4 / (2e-8 * 4.78e-3)));
  CHECK(*reduced_unit("V/m", units) == Approx(1.52e-4 / (2e-8 * 4.78e-3)));
  CHECK(*reduced_unit("kg/m^3", units) == Approx(1.52e-4 / std::pow(4.78e-3, 3)));
  CHECK(!reduced_unit("K", units));
}

}  // namespace granular_si_test
