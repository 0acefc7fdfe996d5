// Tests of solve with electrodes of shape polygon, ellipse and curve: floating electrodes, forces and torques.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/commands.hpp"

namespace commands_curves_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;
using nlohmann::json;

namespace {

/// Scene of a plate capacitor with an oblique ellipse at its centre, which has a `source`: a potential or a charge.
std::string scene_with(const std::string& source, const std::string& more = "") {
  return R"(
  [domain]
  size = [0.02, 0.02]
  left = { potential = 0.0 }
  right = { potential = 10.0 }
  [medium]
  permittivity = 4e-11
  depth = 2e-3
  [effects.floating_conductors]
  [field]
  cells = 256
  tolerance = 1e-11
  [[electrode]]
  name = "egg"
  shape = "ellipse"
  centre = [0.01, 0.01]
  semi_axes = [0.004, 0.002]
  angle = 45
)" + source +
         "\n" + more;
}

json solved(const std::string& text) {
  const Folder folder;
  folder.write("scene.toml", text);
  const Ended ended = run(folder, "solve scene.toml --json");
  CAPTURE(ended.err);
  REQUIRE(ended.status == 0);
  return json::parse(ended.out);
}

}  // namespace

TEST_CASE("floating ellipse between plates: mean potential, torque into the field") {
  const json answer = solved(scene_with("charge = 0.0"));
  CHECK(answer["electrodes"][0]["potential"].get<double>() == doctest::Approx(5).epsilon(1e-8));
  const json force = answer["electrode_forces"][0];
  CHECK(force["name"] == "egg");
  // eps pi (a^2 - b^2) E_a E_b in a wide space; the plates strengthen the field.
  const double free = -4e-11 * 2e-3 * std::acos(-1.0) * 12e-6 * 0.5 * 500 * 500;
  CHECK(force["torque"].get<double>() / free > 1);
  CHECK(force["torque"].get<double>() / free < 1.4);
  CHECK(std::abs(force["force"][0].get<double>()) < 1e-6 * std::abs(free) / 0.004);
  CHECK(force["centroid"][0].get<double>() == doctest::Approx(0.01));
}

TEST_CASE("floating ellipse: its charge gives the potential that has this charge") {
  const json given = solved(scene_with("potential = 7.5"));
  const double charge = given["electrodes"][0]["charge"];
  const json floating = solved(scene_with(fmt::format("charge = {:.17g}", charge)));
  CHECK(floating["electrodes"][0]["potential"].get<double>() == doctest::Approx(7.5).epsilon(1e-8));
  CHECK(floating["electrodes"][0]["charge"].get<double>() == doctest::Approx(charge).epsilon(1e-10));
}

TEST_CASE("forces on electrodes: sharp corners have none, rounded ones have") {
  const std::string square =
      "[[electrode]]\nname = \"square\"\nshape = \"polygon\"\npotential = 1.0\n"
      "points = [[0.001, 0.001], [0.004, 0.001], [0.004, 0.004], [0.001, 0.004]]\n";
  CHECK(solved(scene_with("charge = 0.0", square))["electrode_forces"].size() == 1);
  const json rounded = solved(scene_with("charge = 0.0", square + "corner_radius = 0.0009\n"));
  REQUIRE(rounded["electrode_forces"].size() == 2);
  CHECK(rounded["electrode_forces"][1]["name"] == "square");
}

}  // namespace commands_curves_test
