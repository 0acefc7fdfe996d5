#include <doctest/doctest.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/schema.hpp"
#include "tests/scene_texts.hpp"

namespace scene_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

namespace {

/// Value of the key's type in which each number is `number`; empty if the key has no real number.
std::string with_number(const Key& key, const std::string& number) {
  const std::string pair = "[" + number + ", " + number + "]";
  const Overloaded text{
      []<class T>(const T&) { return std::string(); },
      [&](At<double>) { return number; },
      [&](At<std::optional<double>>) { return number; },
      [&](At<std::optional<Interval>>) { return number; },
      [&](At<Vec2>) { return pair; },
      [&](At<Coordinates>) { return pair; },
      [&](At<std::optional<Coordinates>>) { return pair; },
      [&](At<std::vector<double>>) { return pair; },
      [&](At<std::optional<Region>>) { return "[" + pair + ", " + pair + "]"; },
      [&](At<DomainSide>) { return "{ potential = " + number + " }"; },
  };
  return std::visit(text, key.target);
}

}  // namespace

TEST_CASE("scene file: every value is stored in its option") {
  const Scene s = parse(R"(
title = "All of it"
seed = 7
[domain]
size = [0.04, 0.02]
left = { potential = -5.0 }
right = { potential = 3 }
top = "insulating"
[medium]
permittivity = 4e-11
viscosity = 0.5
depth = 0.01
[material]
density = 1000
[[conductor]]
position = [0.01, 0.01]
radius = 0.001
charge = 2e-10
velocity = [0.1, -0.2]
[[conductor]]
position = [0.02, 0.01]
radius = 0.002
group = "wire"
[[group]]
name = "wire"
potential = 12.0
[effects.floating_conductors]
[effects.current_injection]
current = -1e-9
[effects.stokes_drag]
[effects.hertz_contact]
young = 1e9
poisson = 0.25
[effects.wall_contact]
young = 2e9
[effects.contact_discharge]
contact_distance = 1e-4
hysteresis = 0.5
[field]
method = "relaxation"
cells = 64
tolerance = 1e-6
moving_tolerance = 1e-3
boundary_stencil = "plain"
linear_solver = "assembled"
relaxation_eta = 0.01
[mechanics]
integrator = "euler"
euler_step = 1e-6
euler_field_step = 1e-4
[output]
file = "there.h5"
every = 0.5
checkpoint_every = 3
picture = false
[stop]
time = 9
stationary = false
force = 0.01
)");
  CHECK(s.title == "All of it");
  CHECK(s.seed == 7);
  CHECK(s.domain.size == Vec3{0.04, 0.02, 0});
  CHECK((s.domain.sides[0].electrode && s.domain.sides[0].potential == -5));
  CHECK((s.domain.sides[1].electrode && s.domain.sides[1].potential == 3));
  CHECK_FALSE(s.domain.sides[2].electrode);
  CHECK_FALSE(s.domain.sides[3].electrode);
  CHECK(s.medium.permittivity == 4e-11);
  CHECK(s.medium.viscosity == 0.5);
  CHECK(s.medium.depth == 0.01);
  CHECK(s.material.density == 1000);
  REQUIRE(s.conductors.size() == 2);
  CHECK(s.conductors[0].position == Vec3{0.01, 0.01, 0});
  CHECK(s.conductors[0].velocity == Vec3{0.1, -0.2, 0});
  CHECK(s.conductors[0].charge == 2e-10);
  CHECK(s.conductors[0].group == -1);
  CHECK(s.conductors[1].radius == 0.002);
  CHECK(s.conductors[1].group == 0);
  REQUIRE(s.groups.size() == 1);
  CHECK(s.groups[0].name == "wire");
  CHECK(s.groups[0].potential == 12.0);
  CHECK(s.effects.has<effects::FloatingConductorsOptions>());
  CHECK(s.effects.find<effects::CurrentInjectionOptions>()->current == -1e-9);
  CHECK(s.effects.has<effects::StokesDragOptions>());
  CHECK(s.effects.find<effects::HertzContactOptions>()->young == 1e9);
  CHECK(s.effects.find<effects::HertzContactOptions>()->poisson == 0.25);
  CHECK(s.effects.find<effects::WallContactOptions>()->young == 2e9);
  CHECK(s.effects.find<effects::WallContactOptions>()->poisson == 0.3);
  CHECK(s.effects.find<effects::ContactDischargeOptions>()->contact_distance == 1e-4);
  CHECK(s.effects.find<effects::ContactDischargeOptions>()->hysteresis == 0.5);
  CHECK(s.field().method == &relaxation_method());
  CHECK(s.field().cells == 64);
  CHECK(s.field().tolerance == 1e-6);
  CHECK(s.field().moving_tolerance == 1e-3);
  CHECK(s.field().links == FieldLinks::plain);
  CHECK(s.field().linear_solver == FieldLinearSolver::assembled);
  CHECK(s.field().relaxation_eta == 0.01);
  CHECK(s.mechanics.integrator == Integrator::euler);
  CHECK(s.mechanics.euler_step == 1e-6);
  CHECK(s.mechanics.euler_field_step == 1e-4);
  CHECK(s.output.file == "there.h5");
  CHECK(s.output.every == 0.5);
  CHECK(s.output.checkpoint_every == 3);
  CHECK_FALSE(s.output.picture);
  CHECK(s.stop.time == 9);
  CHECK_FALSE(s.stop.stationary);
  CHECK(s.stop.force == 0.01);
}

TEST_CASE("[mechanics]: keys that the integrator reads are accepted, others not") {
  const std::string scene = box + disk("[0.01, 0.01]") + "[mechanics]\n";
  const MechanicsOptions split =
      parse(scene + "relative_tolerance = 1e-5\nposition_tolerance = 1e-7\nlargest_step = 0.25\n").mechanics;
  CHECK(split.relative_tolerance == 1e-5);
  CHECK(split.position_tolerance == 1e-7);
  CHECK(split.largest_step == 0.25);
  const std::string monolithic = "coupling = \"monolithic\"\n", euler = "integrator = \"euler\"\n";
  CHECK(parse(scene + monolithic + "relative_tolerance = 1e-5\n").mechanics.coupling == FieldCoupling::monolithic);
  CHECK(parse(scene + monolithic + "largest_step = 0.25\n").mechanics.largest_step == 0.25);
  check_refused(scene + monolithic + "predictor = false\n",
                {"mechanics.predictor is not allowed with mechanics.coupling = \"monolithic\""});
  check_refused(scene + euler + "position_tolerance = 1e-7\n",
                {"mechanics.position_tolerance is not allowed with mechanics.integrator = \"euler\""});
  check_refused(scene + "euler_step = 1e-6\n",
                {"mechanics.euler_step is not allowed with mechanics.integrator = \"cvode\""});
}

TEST_CASE("scene file: missing keys get their defaults") {
  const Scene s =
      parse_scene(box +
                      "effects = { floating_conductors = {}, contact_discharge = {} }\n"
                      "output = { every = 0.2 }\nfield.cells = 64\n" +
                      grounded + disk("[0.01, 0.01]") + "[[conductor]]\nposition = [0.035, 0.01]\nradius = 0.002\n",
                  "some/where/name.toml");
  CHECK(s.path == "some/where/name.toml");
  CHECK(s.medium.permittivity == doctest::Approx(2 * 8.8541878128e-12).scale(0).epsilon(1e-15));  // One rounding.
  CHECK(s.medium.depth == 2 * 0.002);                                                    // Twice the largest radius.
  CHECK(s.effects.find<effects::ContactDischargeOptions>()->contact_distance == 0.001);  // The smallest radius.
  CHECK(s.effects.find<effects::ContactDischargeOptions>()->hysteresis == 0.05);
  CHECK(s.mechanics.position_tolerance == 1e-3 * 0.001);
  CHECK(s.mechanics.largest_step == 0.2);
  CHECK(s.output.file == "name.h5");
  CHECK(s.field().relaxation_eta == 0);
  CHECK(s.conductors[0].charge == 0);
  CHECK(s.conductors[0].velocity == Vec3{});
  CHECK(s.material.density == 8050);
  CHECK(s.electrodes[0].name == "disk 1");
  CHECK(s.seed == 1);
}

TEST_CASE("scene without effect tables: has no effects") {
  const Scene s = parse("domain = { size = [0.04, 0.02] }\nfield.cells = 64\n" + disk("[0.01, 0.01]"));
  CHECK_FALSE(s.effects.has<effects::FloatingConductorsOptions>());
  CHECK_FALSE(s.effects.has<effects::CurrentInjectionOptions>());
  CHECK_FALSE(s.effects.has<effects::StokesDragOptions>());
  CHECK_FALSE(s.effects.has<effects::HertzContactOptions>());
  CHECK_FALSE(s.effects.has<effects::WallContactOptions>());
  CHECK_FALSE(s.effects.has<effects::ContactDischargeOptions>());
}

TEST_CASE("wrong unit or type in a scene: the message states the expected one") {
  check_refused("domain.size = [\"5.12 cm\", \"5.12 cm\"]\n",
                {"test.toml:1:", "domain.size = [\"5.12 cm\", \"5.12 cm\"]", "wrong unit or type", "two numbers [x, y]",
                 "in m", "without the unit"});
  check_refused("[domain]\nsize = [1, 1]\n[medium]\nviscosity = \"0.7 Pa s\"\n",
                {"test.toml:4:", "medium.viscosity = \"0.7 Pa s\"", "wrong unit or type", "a number in Pa s",
                 "without the unit"});
  check_refused("domain.size = 0.017\n", {"domain.size = 0.017 has the wrong unit or type", "two numbers"});
  check_refused("domain.size = [0.04, 0.02, 0.01, 0.01]\n", {"domain.size", "wrong unit or type", "two numbers"});
  check_refused(box + "field.cells = 64.5\n", {"field.cells = 64.5", "wrong unit or type", "an integer"});
  check_refused(box + "seed = \"lucky\"\n", {"seed = \"lucky\"", "wrong unit or type", "an integer"});
  check_refused(box + "seed = -1\n", {"seed = -1", "at least 0"});
  check_refused(box + "title = 5\n", {"title = 5", "wrong unit or type", "a text"});
  check_refused(box + "output.picture = \"yes\"\n", {"output.picture = \"yes\"", "true or false"});
  check_refused(box + "output.file = \"\"\n", {"output.file = \"\"", "not empty"});
  check_refused(box + "field.method = \"magic\"\n",
                {"field.method = \"magic\"", "one of \"cut-cell\", \"multipole\", \"relaxation\""});
  check_refused("domain = { size = [1, 1], left = { potential = \"18 kV\" } }\n",
                {"domain.left", "18 kV", "\"insulating\", { potential = a number in V"});
  check_refused("domain = { size = [1, 1], left = \"open\" }\n", {"domain.left = \"open\"", "insulating"});
  check_refused("[[domain]]\nsize = [1, 1]\n", {"domain", "it must be a table, headed [domain]"});
  check_refused(box + "[conductor]\n", {"conductor", "it must be a table for each, headed [[conductor]]"});
  check_refused(box + "conductor = [1]\n", {"conductor = 1", "headed [[conductor]]"});
  check_refused(box + "effects.stokes_drag = true\n", {"effects.stokes_drag = true", "headed [effects.stokes_drag]"});
}

TEST_CASE("value out of range in a scene: the message states the range") {
  check_refused(box + "[[conductor]]\nposition = [0.01, 0.01]\nradius = -0.001\n",
                {"test.toml:5:", "conductor.radius = -0.001", "a number in m, greater than 0"});
  check_refused("domain.size = [0.04, 0]\n", {"domain.size", "at least 1e-50 and at most 1e+50"});
  check_refused("domain.size = [0.04, nan]\n", {"domain.size", "is not allowed"});
  check_refused(box + disk("[inf, 0.01]"), {"conductor.position", "is not allowed"});
  check_refused(box + disk("[0.01, 0.01]", "charge = nan\n"), {"conductor.charge = nan", "is not allowed"});
  check_refused("domain = { size = [1, 1], left = { potential = inf } }\n", {"domain.left", "is not allowed"});
  check_refused(box + "field.cells = 7\n", {"field.cells = 7", "at least 8"});
  check_refused(box + "field.cells = 4294967360\n", {"field.cells = 4294967360", "at most 32768"});  // 2^32 + 64
  check_refused(box + "effects.hertz_contact.poisson = 0.51\n", {"poisson = 0.51", "greater than -1 and at most 0.5"});
  check_refused(box + "field.tolerance = 0\n", {"field.tolerance = 0", "greater than 0 and less than 1"});
}

TEST_CASE("missing keys and tables in a scene: the message names them") {
  check_refused("title = \"empty\"\n", {"[domain] is missing"});
  check_refused("[domain]\n", {"domain.size is missing", "two numbers [x, y] or three", "in m"});
  check_refused(box + "[[conductor]]\nradius = 0.001\n",
                {"test.toml:3:", "conductor.position is missing", "[[conductor]]"});
  check_refused(box + "[effects.current_injection]\n",
                {"effects.current_injection.current is missing", "a number in A"});
  check_refused(box + "[[electrode]]\nshape = \"bar\"\nfrom = [0.01, 0.01]\nto = [0.02, 0.01]\nwidth = 0.001\n",
                {"electrode.potential is missing", "electrode.charge", "[[circuit]]"});
  check_refused(box + disk("[0.01, 0.01]", "shape = \"bar\"\n"),
                {"unknown key conductor.shape", "a floating conductor of this shape is an [[electrode]]"});
  check_refused(box + "field.cells = 64\n", {"no conductors", "[[conductor]] or [[population]]"});
}

TEST_CASE("files that are no scenes: refused, TOML errors with line and column") {
  CHECK_THROWS_WITH_AS(read_scene("no/such/scene.toml"), "no/such/scene.toml: there is no such scene file", InputError);
  CHECK_THROWS_AS(read_scene(shipped_scenes().string()), InputError);  // A directory.
  // Line 2, column 8: the value expected after the equal sign.
  check_refused("title = \"x\"\nseed = \n", {"test.toml:2:8: not a TOML file"});
}

TEST_CASE("effects that need other tables or keys: the message names them") {
  const std::string start = "domain.size = [0.04, 0.02]\nfield.cells = 64\n";
  const std::string end = disk("[0.01, 0.01]");
  check_refused(start + "effects.current_injection.current = 1e-9\n" + end,
                {"effects.current_injection needs", "[effects.floating_conductors]"});
  check_refused(start + "effects.contact_discharge = {}\n" + end,
                {"effects.contact_discharge needs", "[effects.floating_conductors]"});
  check_refused(start + "effects.stokes_drag = {}\n" + end, {"effects.stokes_drag needs", "medium.viscosity in Pa s"});
  check_refused(start + electrostatics.substr(0, electrostatics.find('\n') + 1) + end,
                {"effects.floating_conductors needs", "medium.relative_permittivity", "F/m"});
  check_refused(start + "medium = { permittivity = 1e-11, relative_permittivity = 2 }\n" + end,
                {"medium.permittivity and medium.relative_permittivity", "only one"});
}

TEST_CASE("field.cells: cells must be square, numbers that fit are suggested") {
  const std::string end = disk("[0.01, 0.01]");
  // 0.02 m at a cell of 0.04 m / 63 is 31.5 cells; for sides of 2 to 1 even numbers fit.
  check_refused("domain.size = [0.04, 0.02]\nfield.cells = 63\n" + end,
                {"domain.size = [0.04, 0.02]", "field.cells = 63", "31.5", "field.cells = 62 or 64 would do"});
  // No number of cells fits sides of 1 to 0.7321. The message states a suitable length: 375 cells of 0.05 m / 512.
  check_refused("domain.size = [0.05, 0.036605]\nfield.cells = 512\n" + end, {"0.0366210"});
  // 0.1 / (0.7 / 14) is 2 + 4e-16 in binary and counts as 2.
  CHECK(refusal("domain.size = [0.7, 0.1]\nfield.cells = 14\n" + end) == "");
}

TEST_CASE("relaxation method: a radius below half a cell's diagonal is refused") {
  const auto with_cells = [](int cells) {
    return "domain.size = [0.04, 0.04]\nfield = { method = \"relaxation\", cells = " + std::to_string(cells) + " }\n" +
           disk("[0.01, 0.01]");
  };
  // Half a cell's diagonal is 0.0283 m / cells: 1 mm at 28.3 cells.
  check_refused(with_cells(28), {"field.method = \"relaxation\"", "field.cells must be at least 29"});
  CHECK(refusal(with_cells(29)) == "");
}

TEST_CASE("multipole method: bars, rings, cut or overlapping disks are refused") {
  const auto with = [](const std::string& electrode) {
    return "domain = { size = [0.04, 0.02], bottom = { potential = 0 }, left = { potential = 0 } }\n"
           "field = { method = \"multipole\", cells = 64 }\n[[electrode]]\nname = \"e\"\npotential = 0.0\n" +
           electrode + disk("[0.03, 0.01]");
  };
  const std::string circle = "radius = 0.005\nshape = ";
  check_refused(with("shape = \"ring\"\ncentre = [0.02, 0.01]\nradius = 0.02\n"),
                {"test.toml:3:", "field.method = \"multipole\"", "\"e\" is a ring", "\"cut-cell\""});
  check_refused(with("shape = \"bar\"\nfrom = [0.01, 0.01]\nto = [0.02, 0.01]\nwidth = 0.001\n"), {"\"e\" is a bar"});
  check_refused(with(circle + "\"disk\"\ncentre = [0.02, 0.016]\n"), {"\"e\" is cut by the top side"});
  check_refused(with(circle + "\"half-disk\"\nside = \"bottom\"\nat = 0.0\n"), {"where two electrode sides meet"});
  check_refused(with(circle + "\"disk\"\ncentre = [0.015, 0.01]\n[[electrode]]\npotential = 0.0\n" + circle +
                     "\"disk\"\ncentre = [0.02, 0.01]\n"),
                {"\"disk 1\" overlaps the electrode \"e\""});
  CHECK(refusal(with(circle + "\"disk\"\ncentre = [0.01, 0.01]\n")) == "");
  CHECK(refusal(with(circle + "\"half-disk\"\nside = \"bottom\"\nat = 0.01\n")) == "");
  // The two sides are an electrode and an insulator.
  CHECK(refusal(with(circle + "\"half-disk\"\nside = \"top\"\nat = 0.0\n")) == "");
}

TEST_CASE("field tolerances: defaults by method, refused below rounding") {
  const auto with = [](const std::string& field) {
    return box + "field = { cells = 64, " + field + " }\n" + disk("[0.01, 0.01]");
  };
  const FieldOptions relaxation = parse(with("method = \"relaxation\"")).field();
  CHECK(relaxation.tolerance == 1e-4);
  CHECK(relaxation.moving_tolerance == 1e-4);
  CHECK(parse(with("method = \"multipole\"")).field().tolerance == 1e-10);
  CHECK(parse(with("method = \"multipole\"")).field().moving_tolerance == 1e-6);
  CHECK(parse(with("method = \"cut-cell\"")).field().tolerance == 1e-8);
  CHECK(parse(with("method = \"relaxation\", tolerance = 1e-6")).field().tolerance == 1e-6);
  const std::string moving = box + electrostatics + grounded + disk("[0.01, 0.01]");
  CHECK(parse(moving).field().moving_tolerance == doctest::Approx(1e-4));
  CHECK(parse(moving + "[mechanics]\nposition_tolerance = 4e-7\n").field().moving_tolerance == doctest::Approx(1.6e-5));
  CHECK(parse(box + "effects.floating_conductors = {}\nfield = { cells = 64, moving_tolerance = 1e-6 }\n" + grounded)
            .field()
            .moving_tolerance == 1e-6);
  check_refused(with("tolerance = 1e-15"), {"field.tolerance = 1e-15", "it must be at least 1e-14", "\"cut-cell\""});
  check_refused(with("moving_tolerance = 1e-15"), {"field.moving_tolerance = 1e-15"});
  check_refused(with("method = \"multipole\", tolerance = 1e-14"), {"it must be at least 1e-13"});
  check_refused(with("method = \"relaxation\", tolerance = 1e-12"), {"it must be at least 1e-10"});
}

TEST_CASE("position_tolerance: 1e-9 of the smallest radius up to the domain's size") {
  const auto with = [](const std::string& tolerance) {
    return box + "field.cells = 64\nmechanics.position_tolerance = " + tolerance + "\n" + disk("[0.01, 0.01]");
  };
  check_refused(with("1e-40"),
                {"test.toml:4:", "mechanics.position_tolerance = 1e-40 m", "it must be at least 1e-12 m"});
  check_refused(with("0.99e-12"), {"at least 1e-12 m"});
  CHECK(refusal(with("1.01e-12")) == "");
  check_refused(with("0.0401"), {"mechanics.position_tolerance = 0.0401 m", "at most 0.04 m"});
  CHECK(refusal(with("0.04")) == "");
}

TEST_CASE("domain.size: refused if it overflows or gaps are lost in rounding") {
  const std::string world = "field.cells = 64\nmedium.relative_permittivity = 4.7\n" + disk("[0.01, 0.01]");
  check_refused("domain.size = [1e300, 1e300]\n" + world, {"test.toml:1:", "domain.size", "at most 1e+50"});
  check_refused("domain.size = [1, 1e-51]\n" + world, {"domain.size", "at least 1e-50"});
  check_refused("domain.size = [2.1e6, 2.1e6]\n" + world,
                {"test.toml:1:", "domain.size = 2.1e+06 m along its longest side", "a conductor of diameter 0.002 m"});
  CHECK(refusal("domain.size = [1.9e6, 1.9e6]\n" + world) == "");
}

TEST_CASE("field.accuracy: replaces cells and tolerances, which are then refused") {
  const auto with = [](const std::string& field) {
    return box + "[field]\naccuracy = 1e-3\n" + field + disk("[0.01, 0.01]");
  };
  CHECK(parse(with("")).field_request()->accuracy == 1e-3);
  CHECK_FALSE(parse(with("")).field_request()->method);
  CHECK(parse(with("method = \"cut-cell\"\n")).field_request()->method == &cut_cell_method());
  CHECK_THROWS_AS(parse(with("")).field(), InputError);
  CHECK_FALSE(parse(box + "field.cells = 64\n" + disk("[0.01, 0.01]")).field_request());
  for (const std::string key : {"cells", "tolerance", "moving_tolerance"})
    check_refused(with(key + (key == "cells" ? " = 64\n" : " = 1e-5\n")),
                  {"test.toml:5:", "field." + key + " is chosen for field.accuracy"});
  check_refused(with("method = \"relaxation\"\n"),
                {"field.method = \"relaxation\" is not allowed with field.accuracy"});
  check_refused(with("boundary_stencil = \"plain\"\n"),
                {"field.boundary_stencil = \"plain\" is not allowed with field.accuracy"});
  check_refused(box + "field.accuracy = 1e-13\n" + disk("[0.01, 0.01]"), {"at least 1e-12 and at most 0.1"});
}

TEST_CASE("output.every: more than 1e9 frames are refused") {
  const auto every = [](const std::string& value) {
    return box + "field.cells = 64\noutput.every = " + value + "\nstop.time = 1.0\n" + disk("[0.01, 0.01]");
  };
  check_refused(every("0.9e-9"), {"output.every = 9e-10 s", "stop.time = 1 s", "at most 1e+09"});
  CHECK(refusal(every("1e-9")) == "");
}

TEST_CASE("times whose squares underflow (1e-300 s): refused") {
  const std::string scene = box + "field.cells = 64\n" + disk("[0.01, 0.01]");
  check_refused(scene + "[stop]\ntime = 1e-300\n", {"stop.time = 1e-300", "at least 1e-50"});
  check_refused(scene + "[mechanics]\nlargest_step = 1e-300\n", {"mechanics.largest_step = 1e-300", "at least 1e-50"});
}

TEST_CASE("numbers of all keys: 1e101, 1e-101 and beyond are refused by name") {
  const Schema schema(effects::all_kinds());
  int numeric = 0;
  for (const Table& table : schema.tables())
    for (const Key& key : table.keys)
      for (const std::string size : {"1.7e308", "1e101", "-1e101", "1e-101", "5e-324"}) {
        const std::string written = with_number(key, size);
        const bool component_near_0 = written.starts_with("[") && size.find("e-") != std::string::npos;
        if (written.empty() || (component_near_0 && key.range.contains(0))) continue;
        ++numeric;
        const bool in_domain = table.path == "domain";
        const std::string domain = in_domain && key.name == "size" ? "" : "size = [0.04, 0.02]\n";
        const std::string line = key.name + " = " + written + "\n";
        check_refused("[domain]\n" + domain +
                          (in_domain                             ? line
                           : table.kind == Table::Kind::repeated ? "[[" + table.path + "]]\n" + line
                                                                 : "[" + table.path + "]\n" + line),
                      {path_in(table, key.name) + " = ", "is not allowed"});
      }
  CHECK(numeric > 5 * 80);
}

TEST_CASE("Draft::line: a key that no scene can have throws std::logic_error") {
  const Draft draft = Schema(effects::all_kinds()).blank_draft();
  CHECK(draft.line("effects.hertz_contact.young") == 0);
  CHECK(draft.line("effects.of_another_program.key") == 0);  // The kind is not in the list.
  CHECK_THROWS_AS(draft.line("effects.hertz_contact.yuong"), std::logic_error);
  CHECK_THROWS_AS(draft.line("hertz_contact.young"), std::logic_error);
}

TEST_CASE("scene help: lists every key with its unit and default") {
  std::istringstream words(scene_help());  // Line breaks are not tested here.
  std::string help;
  for (std::string word; words >> word;) help += word + " ";
  const Schema schema(effects::all_kinds());
  Draft untouched = schema.blank_draft();
  for (const Table& table : schema.tables()) {
    CHECK(has(help, table.header()));
    for (const Key& key : table.keys) {
      CAPTURE(path_in(table, key.name));
      CHECK_FALSE(key.help.empty());
      CHECK(has(help, key.name + " "));
      CHECK(has(help, key.help));
      CHECK(has(help, key.allowed() + "; " + key.fallback(untouched)));
    }
  }
  // An example of each kind in full: unit, range, default from the scene's initial values.
  CHECK(has(help, "an integer, at least 8 and at most 32768; default: 512"));
  CHECK(has(help, "a number in Pa, greater than 0; default: 2e+11"));
  CHECK(has(help, "two numbers [x, y] or three [x, y, z] in m, at least 1e-50 and at most 1e+50; required"));
}

TEST_CASE("Schema: no table or key occurs twice") {
  std::set<std::string> paths;
  const Schema schema(effects::all_kinds());
  for (const Table& table : schema.tables()) {
    CHECK(paths.insert(table.path).second);
    for (const Key& key : table.keys) CHECK(paths.insert(path_in(table, key.name)).second);
  }
}

TEST_CASE("scenes/: every shipped scene is valid") {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(shipped_scenes())) {
    if (entry.path().extension() != ".toml") continue;
    CAPTURE(entry.path().string());
    names.insert(entry.path().stem().string());
    const Scene s = read_scene(entry.path().string());
    if (s.reference)
      CHECK(overlaps_in_space(s) == 0);
    else if (!s.effects.has<effects::SoftRepulsionOptions>())  // A packing starts with overlaps.
      CHECK(least_gap(s) >= 0);
    CHECK(s.output.file == entry.path().stem().string() + ".h5");
    CHECK_FALSE(s.text.empty());
  }
  for (const char* name : {"two-disks", "seedling", "dendrite", "dish"}) CHECK(names.count(name) == 1);

  const Scene dendrite = read_scene((shipped_scenes() / "dendrite.toml").string());
  CHECK(dendrite.conductors.size() == 324);
  CHECK(least_gap(dendrite) >= 0.1e-3);
  CHECK(dendrite.effects.find<effects::ContactDischargeOptions>()->contact_distance == 0.775e-3);
  const Scene two_disks = read_scene((shipped_scenes() / "two-disks.toml").string());
  const Vec3 separation = two_disks.conductors[1].position - two_disks.conductors[0].position;
  CHECK(norm(separation) / (2 * 0.775e-3) == doctest::Approx(2).epsilon(1e-12));  // d/2R = 2, decimal rounding.
}

}  // namespace scene_test
