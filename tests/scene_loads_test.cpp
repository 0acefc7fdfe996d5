// Tests of scenes of packings with periodic sides, weight and loads ([compression]).
#include <doctest/doctest.h>

#include <numbers>
#include <string>

#include "src/effects/soft_repulsion.hpp"
#include "src/scene/loads.hpp"
#include "src/scene/scene.hpp"
#include "tests/scene_texts.hpp"

namespace scene_loads_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

namespace {

const std::string size = "[domain]\nsize = [4.0, 2.0]\n", contact = "[effects.soft_repulsion]\n";
const std::string across = "left = \"periodic\"\nright = \"periodic\"\n";
const std::string some = "[[population]]\ncount = 6\nradius = 0.25\noverlapping = true\n";

std::string loads(const std::string& keys) { return size + contact + some + "[compression]\n" + keys; }

}  // namespace

TEST_CASE("packing, periodic along x: walls are the other sides") {
  const Scene scene = parse(size + across + contact + some);
  REQUIRE(scene.walls.size() == 2);
  CHECK(scene.walls[0].name == "bottom");
  CHECK(scene.walls[1].name == "top");
  const std::string around = size + across + "bottom = \"periodic\"\ntop = \"periodic\"\n";
  CHECK(parse(around + contact + some).walls.empty());
  check_refused(size + across + contact + "box = false\n" + some, {"the packing has no walls"});
  check_refused(size + "left = \"periodic\"\n" + contact + some, {"domain.left = \"periodic\"", "domain.right"});
  check_refused(around + contact + some + "[network]\nterminals = \"bottom,top\"\n", {"no wall \"bottom\""});
  check_refused(size + across + contact + some + "[network]\nterminals = \"left,right\"\n", {"no wall \"left\""});
}

TEST_CASE("packing with gravity: allowed across walls alone, with a density") {
  const std::string heavy = "[effects.gravity]\nacceleration = 9.8\n";
  CHECK(refusal(size + across + contact + some + heavy + "[material]\ndensity = 2000.0\n") == "");
  check_refused(size + across + contact + some + heavy + "direction = [1.0, 0.0]\n",
                {"effects.gravity is not allowed along x", "periodic"});
  check_refused(size + contact + some + "[material]\ndensity = 2000.0\n", {"[material]", "[effects.gravity]"});
  check_refused(loads("excess = [0.1]\n") + heavy, {"compression.excess is not allowed with [effects.gravity]"});
}

TEST_CASE("compression: lists, sides and pressures that cannot be are refused") {
  CHECK(refusal(loads("pressure = [0.1, 0.2]\nplate = \"top\"\n")) == "");
  check_refused(loads(""), {"[compression] has none of the lists"});
  check_refused(loads("pressure = [0.1]\nfilling = [0.5]\n"), {"[compression] has several of the lists"});
  check_refused(loads("filling = [0.5]\ntolerance = 1e-4\n"), {"compression.tolerance is not allowed", "filling"});
  check_refused(loads("pressure = [0.0]\n"), {"compression.pressure = [0] is not allowed", "greater than 0"});
  check_refused(loads("pressure = []\n"), {"compression.pressure", "non-empty"});
  check_refused(loads("filling = [1.1]\n"), {"compression.filling", "at most 1"});
  check_refused(loads("pressure = [1e-9]\n"), {"compression.pressure = 1e-09 is not allowed", "at least 4e-06"});
  check_refused(loads("filling = [0.5]\nplate = \"left\"\n"), {"compression.plate = \"left\"", "\"right\""});
  check_refused(loads("filling = [0.5]\nplate = \"back\"\n"), {"compression.plate = \"back\"", "two dimensions"});
  check_refused(size + across + contact + some + "[compression]\nfilling = [0.5]\nplate = \"right\"\n",
                {"compression.plate = \"right\" is not allowed with domain.right = \"periodic\""});
  check_refused(size + contact + "box = false\n" + some + "[[wall]]\npoint = [1.0, 0.0]\nnormal = [0.0, 1.0]\n" +
                    "[compression]\nfilling = [0.5]\n",
                {"[wall] is not allowed with [compression]"});
  check_refused(size + contact + "box = false\n" + some + "[compression]\nfilling = [0.5]\n",
                {"effects.soft_repulsion.box = false is not allowed with [compression]"});
  check_refused(loads("filling = [0.5]\n") + "[minimize]\nrecord_every = 5\n", {"minimize.record_every"});
  check_refused(size + "[compression]\nfilling = [0.5]\n" + disk("[1.0, 1.0]"),
                {"[compression] needs the table [effects.soft_repulsion]"});
}

TEST_CASE("network resistors by force: only a packing has forces of contacts") {
  const std::string network = "[network]\nresistor = \"hertz\"\nresistivity = 1e-6\nelastic_modulus = 1e11\n";
  CHECK(refusal(size + contact + some + network + "film_resistance = 1e-12\n") == "");
  check_refused(box + "field.cells = 64\n" + disk("[0.01, 0.01]") + network,
                {"network.resistor = \"hertz\"", "packings"});
  check_refused(size + contact + some + network + "hardness = 1e9\n",
                {"network.hardness", "\"hertz\" does not use it", "optional film_resistance"});
}

TEST_CASE("packing fraction: content of disks or spheres over that of the domain") {
  const auto two = [](const std::string& across) {
    return "[[conductor]]\nposition = [1.0, 1.0" + across + "]\nradius = 0.5\n[[conductor]]\nposition = [2.5, 1.0" +
           across + "]\nradius = 0.25\n";
  };
  constexpr double pi = std::numbers::pi;
  CHECK(packing_fraction(parse(size + contact + two(""))) == doctest::Approx(pi * (0.25 + 0.0625) / 8));
  CHECK(packing_fraction(parse("[domain]\nsize = [4.0, 2.0, 3.0]\n" + contact + two(", 1.0"))) ==
        doctest::Approx(4 * pi / 3 * (0.125 + 0.015625) / 24));
}

TEST_CASE("resized: walls and positions follow the sides") {
  const Scene before = parse(size + contact + some), after = resized(before, {2, 3, 0});
  CHECK(after.walls[1].point.x == 2);
  CHECK(after.walls[3].point.y == 3);
  CHECK(after.conductors[0].position.x == doctest::Approx(0.5 * before.conductors[0].position.x));
  CHECK(packing_fraction(after) == doctest::Approx(packing_fraction(before) * 8 / 6));
}

}  // namespace scene_loads_test
