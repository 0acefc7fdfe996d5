// Tests of scene files with electrodes of shape polygon, ellipse and curve.
#include <doctest/doctest.h>

#include <numbers>
#include <string>

#include "solvers/geometry/closed_curve.hpp"
#include "tests/scene_texts.hpp"

namespace scene_curves_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

/// Electrode of a shape with these keys, in the domain of 0.04 m times 0.02 m with cells of 0.6 mm.
std::string electrode(const std::string& shape, const std::string& keys, const std::string& name = "e") {
  return "[[electrode]]\nname = \"" + name + "\"\nshape = \"" + shape + "\"\npotential = 0\n" + keys + "\n";
}

const std::string square = "points = [[0.01, 0.005], [0.02, 0.005], [0.02, 0.015], [0.01, 0.015]]";

TEST_CASE("polygon, ellipse and curve: read with their keys") {
  const Scene scene = parse(
      box + electrostatics + disk("[0.03, 0.01]") + electrode("polygon", square + "\ncorner_radius = 0.001", "a") +
      electrode("ellipse", "centre = [0.005, 0.01]\nsemi_axes = [0.004, 0.002]\nangle = 90", "b") +
      electrode("curve",
                "points = [[0.035, 0], [0.04, 0.01], [0.035, 0.02], [0, 0.01]]\n"
                "hollow = true",
                "c"));
  REQUIRE(scene.electrodes.size() == 3);
  const ClosedCurve& polygon = *std::get<Freeform>(scene.electrodes[0].shape).curve;
  CHECK(polygon.area() == doctest::Approx(1e-4 - (4 - std::numbers::pi) * 1e-6).epsilon(1e-12));
  const ClosedCurve& ellipse = *std::get<Freeform>(scene.electrodes[1].shape).curve;
  CHECK(ellipse.high().y == doctest::Approx(0.014));
  CHECK(ellipse.high().x == doctest::Approx(0.007));
  CHECK(std::get<Freeform>(scene.electrodes[2].shape).curve->hollow());
}

TEST_CASE("polygon: bad points are refused with the electrode and the key") {
  const auto check = [](const std::string& points, const std::string& part) {
    check_refused(box + electrostatics + electrode("polygon", "points = " + points),
                  {"electrode.points", "\"e\"", part});
  };
  check("[[0.01, 0.01], [0.02, 0.01]]", "is open: it has 2 points");
  check("[[0.01, 0.005], [0.02, 0.005], [0.01, 0.015], [0.02, 0.015]]", "crosses itself: the side from point 2 to 3");
  check("[[0.01, 0.005], [0.02, 0.005], [0.015, 0.005], [0.015, 0.01]]", "folds back on itself at point 2");
  check("[[0.01, 0.005], [0.02, 0.005], [0.02, 0.01], [0.01, 0.005]]", "has equal points 4 and 1");
  check("[[0.01, 0.005], [0.02, 0.005], [0.02, 0.0052], [0.01, 0.0052]]", "is thinner than a cell");
  check("[[0.01, 0.005], [0.0102, 0.005], [0.01, 0.0052]]", "is thinner than a cell");
  check("[[0.05, 0.005], [0.06, 0.005], [0.06, 0.01]]", "lies outside the domain");
  check_refused(box + electrostatics + electrode("polygon", square + "\ncorner_radius = 0.006"),
                {"electrode.points", "too short for its rounded corners"});
  check_refused(box + electrostatics + electrode("polygon", square + "\nangle = 3"),
                {"electrode.angle does not belong", "\"polygon\"", "only to ellipse"});
  check_refused(box + electrostatics + electrode("polygon", ""), {"electrode.points is missing", "\"polygon\""});
  check_refused(box + electrostatics + electrode("polygon", "points = [[0.01, 0.01, 0.01]]"), {"list of points"});
  check_refused(box + electrostatics + electrode("ellipse", "centre = [0.01, 0.01]\nsemi_axes = [0.01, 0]"),
                {"electrode.semi_axes", "greater than 0"});
  check_refused(
      box + electrostatics + electrode("ellipse", "centre = [0.02, 0.01]\nsemi_axes = [0.1, 0.1]\nhollow = true"),
      {"electrode.semi_axes", "does not reach into the domain"});
}

TEST_CASE("closed curves that touch others at another potential: refused") {
  const auto live = [](const std::string& shape, const std::string& keys) {
    return "[[electrode]]\nname = \"live\"\nshape = \"" + shape + "\"\npotential = 5\n" + keys + "\n";
  };
  const std::string scene = box + electrostatics + electrode("polygon", square);
  const auto check = [&](const std::string& other, bool touches) {
    const std::string message = refusal(scene + other);
    CAPTURE(message);
    CHECK(has(message, "electrodes that touch must have the same potential") == touches);
    CHECK(message.empty() != touches);
  };
  for (const bool touches : {true, false}) {
    const std::string x = touches ? "0.021" : "0.0235";
    check(live("disk", "centre = [" + x + ", 0.01]\nradius = 0.002"), touches);
    check(live("bar", "from = [" + x + ", 0.004]\nto = [" + x + ", 0.016]\nwidth = 0.003"), touches);
    check(live("ellipse", "centre = [" + x + ", 0.01]\nsemi_axes = [0.002, 0.004]"), touches);
    check(live("ring", "centre = [0.015, 0.01]\nradius = " + std::string(touches ? "0.007" : "0.0075")), touches);
    const std::string size = touches ? "0.007" : "0.0075";
    check(live("ellipse", "centre = [0.015, 0.01]\nsemi_axes = [" + size + ", " + size + "]\nhollow = true"), touches);
  }
  check(live("ellipse", "centre = [0.015, 0.01]\nsemi_axes = [0.002, 0.002]"), true);  // inside
}

TEST_CASE("closed curves: methods that cannot solve them are refused by name") {
  const auto with = [](const std::string& field) {
    return box + "effects.floating_conductors = {}\nfield = { " + field + " }\n" + disk("[0.03, 0.01]") +
           electrode("polygon", square);
  };
  check_refused(with("method = \"relaxation\", cells = 64"),
                {"\"relaxation\"", "\"e\"", "\"polygon\"", "\"cut-cell\""});
  check_refused(with("method = \"multipole\""), {"\"multipole\"", "\"e\"", "is a polygon", "\"cut-cell\""});
  check_refused(with("cells = 64, device = \"cuda\""), {"field.device = \"cuda\"", "\"e\"", "\"cpu\" is allowed"});
  CHECK(refusal(with("cells = 64")).empty());
  check_refused(
      "domain = { size = [0.04, 0.02, 0.02] }\nmedium = { relative_permittivity = 2.0 }\n"
      "effects.floating_conductors = {}\n" +
          electrode("polygon", square),
      {"\"polygon\" is not allowed in three dimensions"});
}

TEST_CASE("conductor that touches a closed curve: refused without discharge") {
  check_refused(box + electrostatics + electrode("polygon", square) + disk("[0.021, 0.01]"),
                {"touches the electrode \"e\""});
  CHECK(refusal(box + electrostatics + electrode("polygon", square) + disk("[0.022, 0.01]")).empty());
}

}  // namespace scene_curves_test
