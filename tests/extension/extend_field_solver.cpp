// Field method added from outside: one charged disk in front of a grounded plane.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/commands/command_line.hpp"
#include "src/effects/read_scene.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/record/result.hpp"
#include "tests/folder.hpp"

namespace extend_field_solver {

using namespace lichtenberg;

namespace {

/// Capacitance per depth (F/m) of a disk in front of a plane, over the permittivity: 2 pi / arcosh(height / radius).
double theory(double height, double radius) { return 2 * std::numbers::pi / std::acosh(height / radius); }

/// Solver for a floating disk at the grounded bottom side with all other sides far away: one line charge and its image.
class ImageCharge : public laplace::LaplaceSolver {
 public:
  laplace::LaplaceSolution solve(const laplace::LaplaceProblem& problem) override {
    if (problem.bodies.size() != 1 || problem.sides[laplace::bottom].kind != laplace::Side::Kind::electrode)
      throw InputError("images solves one disk before a bottom that is an electrode");
    const Disk& disk = std::get<Disk>(problem.bodies.front().shape);
    const double charge = problem.groups.front().charge,
                 focus = std::sqrt(disk.centre.y * disk.centre.y - disk.radius * disk.radius);
    const double potential = charge / (problem.permittivity * theory(disk.centre.y, disk.radius));
    laplace::LaplaceSolution solution{.group_potential = {potential}, .body_charge = {charge}};
    // Two line charges at a distance of 2 * focus attract each other.
    solution.body_force = {{0, -charge * charge / (4 * std::numbers::pi * problem.permittivity * focus)}};
    solution.side_charge[laplace::bottom] = -charge;
    solution.energy = charge * potential / 2;
    solution.unknowns = solution.iterations = 1;
    return solution;
  }
  laplace::Field field() const override { return {.nx = 1, .ny = 1, .h = 1, .value = {0}, .body = {-1}}; }
  void forget() override {}
};

const FieldMethodKind images = {.name = "images",
                                .help = "one disk before a plane",
                                .make = [](const FieldOptions&) -> std::unique_ptr<laplace::LaplaceSolver> {
                                  return std::make_unique<ImageCharge>();
                                },
                                .keys = {},
                                .tolerance = {.single = 1e-12, .moving = 1e-12, .least = 1e-15},
                                .only_disks = true};

std::string scene_text(const std::string& field, const std::string& more = "") {
  return "domain = { size = [1.0, 0.5], bottom = { potential = 0.0 } }\nmedium = { relative_permittivity = 2.0, depth "
         "= 1.0, viscosity = 1e-3 }\n" +
         field +
         "effects.floating_conductors = {}\nstop = { time = 1e-3 }\noutput = { every = 1e-3, picture = false }\n" +
         more + "[[conductor]]\nposition = [0.5, 0.01]\nradius = 0.002\ncharge = 1e-12\n";
}

std::string refusal(const std::string& text) {
  try {
    parse_scene(text, "test.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("user-defined field method: help, explain, solve and run accept it") {
  add_field_method(images);
  CHECK_THROWS_AS(add_field_method(images), InputError);
  const Folder folder;
  const std::string scene = (folder / "scene.toml").string(), json = (folder / "answer.json").string();
  std::ofstream(scene) << scene_text("field.method = \"images\"\n", "effects.stokes_drag = {}\n");
  CHECK(contains(scene_help("field.method"), "\"images\""));
  CHECK(run_command_line({"explain", scene}, all_commands()) == 0);
  REQUIRE(run_command_line({"solve", scene, "--json=" + json}, all_commands()) == 0);
  const auto answer = nlohmann::json::parse(std::ifstream(json));
  CHECK(answer["method"] == "images");
  // The capacitance is the theory's, and that of the multipole method in a box whose other sides are far away.
  const double potential = answer["conductors"][0]["potential"], permittivity = 2 * 8.8541878128e-12;
  CHECK(1e-12 / potential == doctest::Approx(permittivity * theory(0.01, 0.002)).epsilon(1e-12));
  REQUIRE(run_command_line({"solve", scene, "--set=field.method=multipole", "--json=" + json, "--overwrite"},
                           all_commands()) == 0);
  const double other = nlohmann::json::parse(std::ifstream(json))["conductors"][0]["potential"];
  CHECK(other == doctest::Approx(potential).epsilon(1e-3));  // (height / distance of the sides)^2.
  REQUIRE(run_command_line({"run", scene, "--quiet", "--out=" + (folder / "result.h5").string()}, all_commands()) == 0);
  CHECK(Result((folder / "result.h5").string()).scene().field().method == &images);
}

TEST_CASE("user-defined field method: keys that it does not support are refused") {
  const std::string field = "field.method = \"images\"\n";
  CHECK(contains(refusal(scene_text(field + "field.cells = 64\n")),
                 "field.cells is not allowed with field.method = \"images\""));
  CHECK(contains(refusal(scene_text(field + "field.boundary_stencil = \"plain\"\n")),
                 "field.boundary_stencil is not allowed with field.method = \"images\""));
  CHECK(contains(refusal(scene_text(field + "field.accuracy = 1e-3\n")), "its error is not estimated"));
  CHECK(contains(refusal(scene_text(field + "field.tolerance = 1e-16\n")), "it must be at least 1e-15"));
}

}  // namespace extend_field_solver
