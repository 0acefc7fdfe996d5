// Tests of scenes with friction, adhesion and walls of grains: keys, SI units and error messages.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "src/effects/flat_walls.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/gas.hpp"
#include "src/granular/granular_motion.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

namespace granular_rough_scenes_test {

using namespace lichtenberg;
using doctest::Approx;

namespace {

const std::string sides = "left = \"periodic\"\nright = \"periodic\"\nbottom = \"periodic\"\ntop = \"periodic\"\n";
const std::string box =
    "[units]\n[domain]\nsize = [12, 12, 12]\n" + sides + "front = \"periodic\"\nback = \"periodic\"\n";
const std::string layer = "[units]\n[domain]\nsize = [12, 12, 12]\n" + sides;
const std::string grains = "[[population]]\ncount = 50\ntemperature = 1\n";
const std::string soft = "[effects.viscoelastic_contact]\n", linear = "[effects.linear_contact]\n";
const std::string friction = "[effects.friction]\n", walls = "[effects.flat_walls]\n";
const std::string adhesion = "[effects.adhesion]\nsurface_energy = 0.05\n";

Scene parse(const std::string& text) { return parse_scene(text, "gas.toml"); }

}  // namespace

TEST_CASE("rough scenes: wrong input is refused with its key") {
  struct Refused {
    std::string text, message;
  };
  const std::string corner = "[[conductor]]\nposition = [6, 6, 0.4]\nradius = 0.5\n";
  const std::vector<Refused> table = {
      {box + grains + soft + friction + "inertia = 0\n", "effects.friction.inertia = 0 is not allowed"},
      {box + grains + soft + friction + "coefficient = -1\n", "effects.friction.coefficient = -1 is not allowed"},
      {box + grains + soft + friction + "tangential_restitution = 0.5\n",
       "effects.friction.tangential_restitution needs the table [effects.linear_contact]"},
      {box + grains + linear + friction + "tangential_restitution = 0.5\nstiffness_ratio = 0.2\n",
       "effects.friction.stiffness_ratio is given, and so is tangential_restitution"},
      {box + grains + friction, "a scene of grains needs effects.viscoelastic_contact or effects.linear_contact"},
      {box + grains + soft + friction + "[mechanics]\nintegrator = \"verlet\"\n",
       "mechanics.integrator = \"verlet\" is not allowed with effects.friction, whose forces it does not compute: "
       "\"multirate\" is allowed"},
      {box + grains + "rotational_temperature = 1\n" + soft,
       "population.rotational_temperature needs the table [effects.friction]"},
      {box + "[[conductor]]\nposition = [6, 6, 6]\nradius = 0.5\nangular_velocity = [1, 0]\n" + soft + friction,
       "conductor.angular_velocity must have three numbers"},
      {box + grains + soft + walls, "effects.flat_walls needs a side of the domain that is not periodic"},
      {layer + grains + soft, "is not allowed without the table [effects.flat_walls]"},
      {layer + corner + soft + walls, "this conductor reaches out of the domain by 0.1 d0"},
      {layer + grains + soft + walls + "restitution = 0.5\n",
       "effects.flat_walls.restitution needs the table [effects.linear_contact]"},
      {layer + grains + soft + walls + "friction = 0.5\n",
       "effects.flat_walls.friction needs the table [effects.friction]"},
      {layer + grains + soft + walls + "damping = 1e10\n",
       "effects.flat_walls.damping = 1e+10 is too large for its stiffness = 278.6: at most"},
      {box + grains + soft + "young = 1e6\npoisson = 0.3\nviscosity = 1e50\n",
       "effects.viscoelastic_contact.viscosity = 1e+50 is too large for its young = 1e+06: at most"},
      {"[units]\nlength = 1e50\nmass = 1e-50\nvelocity = 1e-50\n" + layer.substr(8) + grains + soft +
           "young = 1e9\npoisson = 0.3\nviscosity = 1e-8\n" + walls,
       "effects.viscoelastic_contact.young = 1e+09 gives a reduced stiffness of inf in the units of the scene: at "
       "least 1e-100 and at most 1e+100 is allowed"},
      {layer + grains + soft + walls + "young = 1e6\n", "but effects.viscoelastic_contact does not"},
      {box + grains + linear + adhesion, "effects.adhesion.model = \"jkr\" is not allowed with effects.linear_contact"},
      {box + grains + soft + "[effects.adhesion]\n", "surface_energy"},
      {box + grains + soft + "[effects.adhesion]\nsurface_energy = 1e3\n",
       "is too large for the stiffness of the contact"},
      {"[domain]\nsize = [1, 1]\n[[conductor]]\nposition = [0.5, 0.5]\nradius = 0.1\n" + friction,
       "material.density is missing: a scene of grains without [units] is in SI"},
  };
  for (const auto& [text, message] : table) {
    CAPTURE(text);
    const std::string found = message_of([&] { GranularMotion motion(parse(text)); });
    CHECK_MESSAGE(found.find(message) != std::string::npos, found);
  }
}

TEST_CASE("rough scenes: a CUDA device refuses friction in the plane") {
  Scene scene = parse(box + grains + soft + friction);
  CHECK_NOTHROW(granular::device::check_scene(scene));
  scene = parse("[units]\n[domain]\nsize = [12, 12]\n" + sides + grains + soft + friction);
  CHECK(message_of([&] { granular::device::check_scene(scene); }).find("grains in the plane") != std::string::npos);
}

// Springs in series: a wall of the grains' material leaves E; an infinitely stiff one doubles it.
TEST_CASE("flat walls: materials in SI give the constants of the contact") {
  const std::string grain = soft + "young = 1e6\npoisson = 0.3\nviscosity = 1e-5\n";
  const auto with = [&](const std::string& young) {
    return parse(layer + grains + grain + walls + "young = " + young + "\npoisson = 0.3\nviscosity = 1e-5\n");
  };
  const Scene equal = with("1e6"), stiff = with("1e15");
  const double elastic = equal.effects.find<effects::ViscoelasticContactOptions>()->elastic;
  const double dissipative = equal.effects.find<effects::ViscoelasticContactOptions>()->dissipative;
  CHECK(*equal.effects.find<effects::FlatWallsOptions>()->stiffness == Approx(elastic));
  CHECK(*equal.effects.find<effects::FlatWallsOptions>()->damping == Approx(dissipative));
  CHECK(*stiff.effects.find<effects::FlatWallsOptions>()->stiffness == Approx(2 * elastic));
}

TEST_CASE("rough scenes: contacts have twice as many substeps by default") {
  CHECK(parse(box + grains + soft).mechanics.contact_steps == 16);
  CHECK(parse(box + grains + soft + friction).mechanics.contact_steps == 32);
  CHECK(parse(box + grains + "relative_damping = 2\n" + soft).mechanics.contact_steps == 32);
}

TEST_CASE("rotational temperature: angular velocities have it") {
  const Scene scene = parse(box + "[[population]]\ncount = 300\nrotational_temperature = 2\n" + soft + friction);
  const granular::Gas gas(scene);
  double squares = 0;
  for (const double w : gas.bodies().angular_velocity) squares += w * w;
  CHECK(gas.bodies().inertia[0] == Approx(0.1));
  // Relative deviation of a sum over 900 components: sqrt(2 / 900) = 0.047.
  CHECK(0.1 * squares / 900 == Approx(2).epsilon(0.2));
}

// Springs of stiffness 2 k_i in series give 2 / (1/1 + 1/4) = 1.6 times the stiffness; masses 1 and 8 have the reduced
// mass 8/9. The overlap is largest at v sqrt(m / A). Substeps meet it within pi/32 of its phase.
TEST_CASE("materials of populations: density and stiffness change the contact") {
  const auto largest_overlap = [](const std::string& material) {
    GranularMotion motion(parse(box + "[[conductor]]\nposition = [5, 6, 6]\nradius = 0.5\nvelocity = [1, 0, 0]\n" +
                                "[[conductor]]\nposition = [6.1, 6, 6]\nradius = 0.5\n" + material + linear +
                                "stiffness = 1e3\ndamping = 0\n[stop]\ntime = 1\n"));
    while (!motion.finished()) motion.advance_to(motion.next_frame(), {});
    for (const auto& [name, value, unit] : motion.summary().quantities)
      if (name == "largest_overlap") return value;
    return 0.0;
  };
  CHECK(largest_overlap("") == Approx(std::sqrt(0.5 / 1e3)).epsilon(6e-3));
  CHECK(largest_overlap("relative_stiffness = 4\nrelative_density = 8\n") ==
        Approx(std::sqrt(8.0 / 9 / 1.6e3)).epsilon(6e-3));
  const std::string gas = "[[population]]\ncount = 20\nrelative_damping = 2\n";
  CHECK(message_of([&] {
          GranularMotion motion(parse(box + gas + soft + "[mechanics]\nintegrator = \"gear\"\n"));
        }).find("mechanics.integrator = \"gear\" does not compute the contacts of relative_damping") !=
        std::string::npos);
}

// Heights of the grains above a wall on which they rest stay above 0, and the side keeps them inside.
TEST_CASE("gas between walls: grains stay inside") {
  const std::string gravity = "[effects.uniform_force]\nacceleration = [0, 0, -1]\n";
  GranularMotion motion(parse(layer + grains + soft + friction + walls + gravity + "[stop]\ntime = 10\n"));
  while (!motion.finished()) motion.advance_to(motion.next_frame(), {});
  const std::vector<double> position = motion.frame().reals("position");
  for (std::size_t i = 2; i < position.size(); i += 3) CHECK((position[i] > 0.4 && position[i] < 11.6));
}

}  // namespace granular_rough_scenes_test
