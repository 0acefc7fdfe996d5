// Functions of time of sources, and the scene's circuits.
#include "src/scene/signal.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "src/scene/circuits.hpp"
#include "tests/folder.hpp"
#include "tests/scene_texts.hpp"

namespace scene_signal_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

namespace {

const std::string electrode = "[[electrode]]\nshape = \"disk\"\ncentre = [0.02, 0.01]\nradius = 0.002\n";
const std::string other = "[[electrode]]\nshape = \"disk\"\ncentre = [0.03, 0.015]\nradius = 0.002\nname = \"b\"\n";
const std::string start = box + electrostatics + disk("[0.01, 0.01]");

}  // namespace

TEST_CASE("Waveform: polygon has jumps, constant ends, exact integrals") {
  const Waveform wave{.points = {{0.5, 2}, {1, 4}, {1, -1}, {3, 1}}};
  CHECK(wave.at(0, true) == 2);
  CHECK(wave.at(0.75, true) == 3);
  CHECK(wave.at(1, false) == 4);
  CHECK(wave.at(1, true) == -1);
  CHECK(wave.at(1 + 1e-15, false) == 4);  // the rounding of a time
  CHECK(wave.at(2, false) == 0);
  CHECK(wave.at(9, true) == 1);
  CHECK(wave.next_corner(0) == 0.5);
  CHECK(wave.next_corner(0.5) == 1);
  CHECK(wave.next_corner(1) == 3);
  CHECK(wave.next_corner(3) == INFINITY);
  CHECK(wave.integral(0, 4) == doctest::Approx(1 + 1.5 + 0 + 1));
  CHECK(wave.largest() == 4);
  CHECK(Signal(wave).value == 2);
  // A distant end does not change early points.
  const Waveform held{.points = {{0, 0}, {1e-4, 1000}, {1e9, 1000}}};
  CHECK(held.at(0, true) == 0);
  CHECK(held.at(5e-5, true) == 500);
  CHECK(held.next_corner(0) == 1e-4);
}

TEST_CASE("Waveform: sine and square have their period, phase and integral") {
  const Waveform sine{.shape = Waveform::Shape::sine, .amplitude = 3, .frequency = 50, .offset = 1, .phase = 90};
  CHECK(sine.at(0, true) == doctest::Approx(4));
  CHECK(sine.at(0.01, true) == doctest::Approx(-2));
  CHECK(sine.integral(0, 0.005) == doctest::Approx(0.005 + 3 / (100 * std::numbers::pi)));
  CHECK(sine.longest_step() == doctest::Approx(1e-3));
  CHECK(sine.next_corner(0) == INFINITY);
  const Waveform square{.shape = Waveform::Shape::square, .amplitude = 3, .frequency = 50, .offset = 1};
  CHECK(square.at(0, true) == 4);
  CHECK(square.at(0, false) == -2);
  CHECK(square.next_corner(0) == doctest::Approx(0.01));
  CHECK(square.at(square.next_corner(0), false) == 4);
  CHECK(square.at(square.next_corner(0), true) == -2);
  CHECK(square.integral(0, 0.015) == doctest::Approx(0.015 + 3 * 0.005));
  double corner = 0;  // Corners keep their side after many periods.
  for (int k = 1; k <= 1000; ++k) corner = square.next_corner(corner);
  CHECK(corner == doctest::Approx(10));
  CHECK(square.at(10, false) != square.at(10, true));
}

TEST_CASE("potential: functions of time are read, also from a file") {
  const auto potential = [](const std::string& text) {
    return parse(start + electrode + "potential = " + text + "\n").electrodes[0].potential;
  };
  CHECK(potential("5") == Signal(5));
  CHECK(potential("{ ramp = [[0.1, 1], [0.2, 3]] }").at(0.15, true) == doctest::Approx(2));
  CHECK(potential("{ amplitude = 2, frequency = 10, shape = \"square\", offset = 1 }").value == 3);
  CHECK(potential("{ amplitude = 2, frequency = 10 }").at(0.025, true) == doctest::Approx(2));
  const Folder folder;
  std::ofstream(folder.path / "v.csv") << "t (s), V (V)\n0, 10\n1; 20 # a comment\n\n200 30\n";
  const std::string text = start + electrode + "potential = { table = \"v.csv\" }\n";
  const Scene scene = parse_scene(text, (folder.path / "test.toml").string());
  CHECK(scene.electrodes[0].potential.at(0.5, true) == 15);
  // The text of the scene has the points, so that a result needs no other file.
  CHECK(parse_scene(scene.text, "elsewhere.toml").electrodes[0].potential == scene.electrodes[0].potential);
  CHECK(parse(start + electrode + "potential = { amplitude = 2, frequency = 50 }\n").mechanics.largest_step ==
        doctest::Approx(1e-3));
}

TEST_CASE("potential: an invalid function of time is refused") {
  const auto refused = [](const std::string& value, std::initializer_list<std::string> parts) {
    check_refused(start + electrode + "potential = " + value + "\n", parts);
  };
  refused("{ ramp = [[0, 1]] }", {"1 points", "at least 2"});
  refused("{ ramp = [[0, 1], [1, 2], [0.5, 3]] }", {"electrode.potential", "point 3", "ascend"});
  refused("{ ramp = [[0, 1], [1, 2], [1, 3], [1, 4]] }", {"three points", "at most two"});
  refused("{ ramp = [[0, 1], [0, 2]] }", {"one time"});
  refused("{ ramp = [[0, 1], [1, nan]] }", {"electrode.potential", "is not allowed"});
  refused("{ ramp = [[0, 1], [1]] }", {"wrong unit or type", "ramp"});
  refused("{ ramp = [[0, 1], [1, 2]], offset = 3 }", {"wrong unit or type"});
  refused("{ amplitude = 1 }", {"wrong unit or type", "frequency"});
  refused("{ amplitude = 1, frequency = 0 }", {"frequency must be greater than 0"});
  refused("{ amplitude = 1, frequency = 5, phase = 361 }", {"phase must be from -360 to 360 degrees"});
  refused("{ amplitude = 1, frequency = 5, shape = \"saw\" }", {"wrong unit or type", "\"square\""});
  refused("{ table = [[0, 1], [10, 2]] }", {"gap", "0 to 10 s", "stop.time = 120"});
  refused("{ table = [[1, 1], [1000, 2]] }", {"gap", "1 to 1000 s"});
  refused("{ table = \"none.csv\" }", {"test.toml:", "there is no table \"none.csv\""});
  refused("{ table = \"\" }", {"test.toml:", "there is no table"});
  refused("{ amplitude = 1, frequency = 1e9 }", {"frequency = 1e+09 Hz", "at most 1e+07"});
  check_refused(start + electrode + "potential = { amplitude = 1, frequency = 50 }\n[mechanics]\nlargest_step = 0.01\n",
                {"mechanics.largest_step = 0.01", "at most 0.001"});
  const Folder folder;
  std::ofstream(folder.path / "v.csv") << "0, 10\n1,\n2, 30\n";
  CHECK_THROWS_WITH_AS(
      parse_scene(start + electrode + "potential = { table = \"v.csv\" }\n", (folder.path / "test.toml").string()),
      doctest::Contains("v.csv:2: this line of the table is not two finite numbers"), InputError);
}

TEST_CASE("[[circuit]]: joins electrodes, sides and groups") {
  const Scene scene = parse(
      start + "group = \"w\"\n[[group]]\nname = \"w\"\n" + electrode + "name = \"a\"\npotential = 0\n" + other +
      "[[circuit]]\nelectrodes = [\"b\", \"left\", \"w\"]\nresistance = 1e9\npotential = 5\ncapacitance = 1e-12\n");
  REQUIRE(scene.circuits.size() == 1);
  CHECK(scene.circuits[0].name == "circuit 1");
  CHECK(scene.circuits[0].resistance == 1e9);
  CHECK(scene.circuits[0].capacitance == 1e-12);
  CHECK(scene.electrodes[0].circuit == -1);
  CHECK(scene.electrodes[1].circuit == 0);
  CHECK(scene.groups[0].circuit == 0);
  CHECK(scene.domain.sides[0].electrode);
  CHECK(scene.domain.sides[0].circuit == 0);
  // A source without a resistance gives its members their potential.
  const Scene direct = parse(start + other + "[[circuit]]\nelectrodes = [\"b\", \"left\"]\npotential = 5\n");
  CHECK(direct.circuits.empty());
  CHECK(direct.electrodes[0].potential == Signal(5));
  CHECK(direct.domain.sides[0].potential == Signal(5));
  const Scene floating = parse(start + electrode + "charge = 1e-12\n" + other + "potential = 0\n");
  REQUIRE(floating.circuits.size() == 1);
  CHECK(floating.circuits[0].charge == 1e-12);
}

TEST_CASE("[[circuit]]: invalid members and sources are refused") {
  const auto refused = [](const std::string& keys, std::initializer_list<std::string> parts) {
    check_refused(start + electrode + "name = \"a\"\npotential = 0\n" + other + "[[circuit]]\n" + keys + "\n", parts);
  };
  refused("electrodes = [\"c\"]", {"\"c\"", "no electrode, side or group", "nearest"});
  refused("electrodes = [\"b\", \"b\"]", {"already in a circuit"});
  refused("electrodes = [\"a\", \"b\"]", {"\"a\"", "potential or a charge of its own"});
  refused("electrodes = [\"b\"]\nresistance = 1e9", {"circuit.potential is missing"});
  refused("electrodes = [\"b\"]\nresistance = 0\npotential = 1", {"circuit.resistance", "greater than 0"});
  refused("electrodes = [\"b\"]\npotential = 1\ncapacitance = 1e-12", {"circuit.capacitance", "circuit.resistance"});
  refused("electrodes = [\"b\"]\npotential = 1\ncurrent = 1e-12", {"circuit.current", "circuit.resistance"});
  refused("electrodes = [\"b\"]\npotential = { table = [[0, 1], [10, 2]] }",
          {"test.toml:21: circuit.potential has a table from 0 to 10 s", "gap"});
  refused("electrodes = []", {"circuit.electrodes", "non-empty"});
  refused("potential = 1", {"circuit.electrodes is missing"});
  refused("electrodes = [\"b\"]\n[[circuit]]\nelectrodes = [\"left\"]\nname = \"circuit 1\"", {"is taken"});
  refused("electrodes = [\"b\"]\ncapacitance = 1e-12\n[effects.leakage]\nconductivity = 1e-12",
          {"circuit.capacitance", "effects.leakage"});
  check_refused(box + electrostatics + disk("[0.01, 0.01]") + electrode,
                {"electrode.potential is missing", "electrode.charge"});
  check_refused(start + electrode + "potential = 1\ncharge = 1\n", {"both a potential and a charge"});
  check_refused(start + electrode + "charge = 1e-12\n", {"net charge", "insulated box"});
  check_refused(start + other + "[[circuit]]\nelectrodes = [\"b\"]\ncurrent = 1e-12\n",
                {"circuit.current feeds charge into an insulated box"});
  check_refused(start + "[[circuit]]\nelectrodes = [\"left\"]\npotential = 1\nresistance = 1\n",
                {"left side", "nothing has a given potential"});
  check_refused("domain = { size = [0.04, 0.02], left = { potential = 0, series_resistance = 0 } }\n",
                {"domain.left", "greater than 0"});
  // A side in a circuit meets another electrode side in a corner.
  check_refused(
      "domain = { size = [0.04, 0.02], bottom = { potential = 0 } }\nmedium = { relative_permittivity = 2.0 "
      "}\n" +
          electrostatics + disk("[0.01, 0.01]") +
          "[[circuit]]\nelectrodes = [\"left\"]\npotential = 0\nresistance = 1\n",
      {"the left side of the domain in a circuit touches the bottom side at 0 V", "corner"});
  check_refused(start + electrode + "potential = 0\n" + electrode + "potential = { amplitude = 1, frequency = 50 }\n",
                {"at 0 V at the start, varying in time touches", "at 0 V: electrodes that touch"});
}

}  // namespace scene_signal_test
