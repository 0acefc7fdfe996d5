// Tests of solve for the field of a scene's first instant, and of explain and run for the same choices.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <tuple>

#include "src/record/hdf5.hpp"
#include "tests/commands.hpp"
#include "tests/source_folder.hpp"

namespace commands_solve_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;
using nlohmann::json;

namespace {

const std::string scenes = source_folder() + "/scenes/";

/// The small scene with a line added to [field], its last table.
std::string small_scene_with(const std::string& line) { return small_scene + "  " + line + "\n"; }

/// The small scene with field.accuracy instead of field.cells.
std::string small_scene_with_accuracy(const std::string& accuracy) {
  std::string scene = small_scene;
  scene.replace(scene.find("cells = 64"), 10, "accuracy = " + accuracy);
  return scene;
}

/// Scene of a plate capacitor: two sides of a box, 16 x 8 mm and 2 mm deep.
const std::string plates = R"(
  [domain]
  size = [16e-3, 8e-3]
  bottom = { potential = 0.0 }
  top = { potential = 100.0 }
  [medium]
  permittivity = 4e-11
  depth = 2e-3
  [effects.floating_conductors]
  [field]
  cells = 64
)";

}  // namespace

TEST_CASE("solve in space: charges of adjoining sides are null; CUDA is refused") {
  const Folder folder;
  folder.write("edge.toml",
               "domain = { size = [1.0, 1.0, 1.0], left = { potential = 0.0 }, front = { potential = 0.0 } }\n"
               "medium = { permittivity = 1.0 }\n[[conductor]]\nposition = [0.5, 0.5, 0.5]\nradius = 0.1\n"
               "charge = 1.0\n[effects.floating_conductors]\n");
  CHECK(contains(run(folder, "solve edge.toml").out, "unknown  the left side"));
  CHECK(contains(run(folder, "solve edge.toml --json").out, "\"charge\": null"));
  check_refused(run(folder, "solve edge.toml --device cuda"), "spheres");
}

TEST_CASE("solve: a scene without field or with unbalanced charge is refused") {
  const Folder folder;
  folder.write("neutral.toml",
               "[domain]\nsize = [1e-2, 1e-2]\n[[conductor]]\nposition = [5e-3, 5e-3]\nradius = 1e-3\n");
  check_refused(run(folder, "solve neutral.toml"), "[effects.floating_conductors]");
  std::string insulated = small_scene;
  insulated.erase(insulated.find("  bottom"), insulated.find("  [medium]") - insulated.find("  bottom"));
  folder.write("insulated.toml", insulated);
  check_refused(run(folder, "solve insulated.toml"), "charge");
}

TEST_CASE("solve --json: fields, charges, forces and energy of two disks") {
  const Ended result = run("solve " + scenes + "two-disks.toml --json --capacitance");
  REQUIRE(result.status == 0);
  const json answer = json::parse(result.out);
  std::vector<std::string> fields;
  for (const auto& [key, value] : answer.items()) fields.push_back(key);
  CHECK(fields == std::vector<std::string>{"capacitance", "conductors", "depth", "electrodes", "energy", "iterations",
                                           "method", "residual", "seconds", "units", "unknowns", "warnings", "work"});
  REQUIRE(answer["conductors"].size() == 2);
  const json& held = answer["conductors"][0];
  const json& floating = answer["conductors"][1];
  for (const std::string field : {"position", "radius", "group", "potential", "charge", "force"})
    CHECK(held.contains(field));
  for (const std::string phase : {"setup", "solve", "forces"}) CHECK(answer["seconds"].contains(phase));

  // D 6.37 with d/2R = 2 and the scene's depth 2R gives 652.1 V without walls, whose effect is within 1 %.
  const double permittivity = 4.7 * 8.8541878128e-12, radius = 0.775e-3, charge = 1e-10;
  const double capacitance = 2 * radius * std::numbers::pi * permittivity / std::acosh(2.0);
  CHECK(held["potential"].get<double>() == 0);
  CHECK(floating["potential"].get<double>() == near(charge / capacitance, 0.01));
  CHECK(held["group"] != floating["group"]);
  // Flux balance: the charges are opposite; the solver's relative tolerance is 1e-10.
  CHECK(floating["charge"].get<double>() == near(charge, 1e-9));
  CHECK(held["charge"].get<double>() == near(-charge, 1e-9));
  // Opposite charges attract with equal strength; the walls are symmetric to both.
  CHECK(held["force"][0].get<double>() > 0);
  CHECK(floating["force"][0].get<double>() == near(-held["force"][0].get<double>(), 1e-6));
  // W = Q phi / 2 with the other conductor at zero.
  CHECK(answer["energy"].get<double>() == near(0.5 * charge * floating["potential"].get<double>(), 1e-8));

  const json& matrix = answer["capacitance"]["matrix"];
  CHECK(answer["capacitance"]["groups"] == json({"ground", "conductor 1"}));
  CHECK(matrix[1][1].get<double>() == near(charge / floating["potential"].get<double>(), 1e-8));
  CHECK(matrix[0][1].get<double>() == near(-matrix[1][1].get<double>(), 1e-8));
}

namespace {

/// Scene of rock salt: eight charged grains in a periodic cube, 1.5 d0 apart.
std::string rock_salt(const std::string& effects) {
  std::string scene = "[units]\n[domain]\nsize = [3, 3, 3]\n";
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"})
    scene += std::string(side) + " = \"periodic\"\n";
  for (int i = 0; i < 8; ++i)
    scene += fmt::format("[[conductor]]\nposition = [{}, {}, {}]\nradius = 0.5\ncharge = {}\n", 0.1 + 1.5 * (i & 1),
                         0.2 + 1.5 * (i >> 1 & 1), 0.3 + 1.5 * (i >> 2), (i ^ i >> 1 ^ i >> 2) & 1 ? -1 : 1);
  return scene + "[effects.linear_contact]\n" + effects;
}

}  // namespace

TEST_CASE("solve: rock salt of charged grains has Madelung's energy and potentials") {
  const Folder folder;
  constexpr double madelung = 1.747564594633182, strength = 0.3;
  for (const std::string sum : {"mesh", "ewald"}) {
    CAPTURE(sum);
    folder.write("salt.toml",
                 rock_salt("[effects.coulomb]\ncoupling_constant = 0.3\naccuracy = 1e-7\nsum = \"" + sum + "\"\n"));
    const Ended ended = run(folder, "solve salt.toml --json");
    REQUIRE_MESSAGE(ended.status == 0, ended.err);
    const json answer = json::parse(ended.out);
    CHECK(answer["method"] == sum);
    CHECK(answer["units"]["energy"] == "m0 v0^2");
    CHECK(answer["energy"].get<double>() == near(-4 * strength * madelung / 1.5, 1e-6));
    REQUIRE(answer["conductors"].size() == 8);
    for (const json& grain : answer["conductors"]) {
      CHECK(grain["potential"].get<double>() * grain["charge"].get<double>() == near(-madelung / 1.5, 1e-6));
      for (const double force : grain["force"]) CHECK(std::abs(force) < 1e-6);  // The force vanishes by symmetry.
      CHECK_FALSE(grain.contains("dipole"));
    }
  }
  const std::string table = run(folder, "solve salt.toml").out;
  CHECK(contains(table, fmt::format("energy      {:.7g} m0 v0^2", -4 * strength * madelung / 1.5)));
}

TEST_CASE("solve: forces on polarized grains are negative energy derivatives") {
  const Folder folder;
  for (const std::string degree : {"1", "3"}) {
    CAPTURE(degree);
    folder.write("salt.toml", rock_salt("[effects.coulomb]\nsum = \"ewald\"\naccuracy = 1e-9\n"
                                        "[effects.induced_dipoles]\npolarizability = 0.05\ntolerance = 1e-9\n"
                                        "degree = " +
                                        degree + "\n"));
    const auto solved = [&](double x) {
      const Ended ended =
          run(folder, fmt::format("solve salt.toml --json --set conductor[0].position=[{},0.2,0.3]", x));
      REQUIRE_MESSAGE(ended.status == 0, ended.err);
      return json::parse(ended.out);
    };
    const json here = solved(0.3);
    constexpr double h = 1e-3;  // The error of the difference is its square over that of the distance.
    const double slope = (solved(0.3 + h)["energy"].get<double>() - solved(0.3 - h)["energy"].get<double>()) / (2 * h);
    CHECK(here["conductors"][0]["force"][0].get<double>() == near(-slope, 1e-5));
    CHECK(here["conductors"][0]["dipole"].size() == 3);
  }
}

TEST_CASE("solve: options for conductors are refused for scenes of charged grains") {
  const Folder folder;
  folder.write("salt.toml", rock_salt("[effects.coulomb]\n"));
  check_refused(run(folder, "solve salt.toml --capacitance"), "--capacitance is for scenes of conductors");
  check_refused(run(folder, "solve salt.toml --field f.hdf"), "--field is for scenes of conductors");
  check_refused(run(folder, "solve salt.toml --out p.png"), "--out is for scenes of conductors");
  check_refused(run(folder, "solve salt.toml --device cuda"), "--device cuda is for scenes of conductors");
  CHECK(contains(run(folder, "solve salt.toml --petsc -ksp_type gmres").err,
                 "the option -ksp_type after --petsc was not used"));
  folder.write("neutral.toml", rock_salt(""));
  check_refused(run(folder, "solve neutral.toml"), "[effects.coulomb]");
}

TEST_CASE("solve: the printed table shows the numbers of the JSON output") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const json answer = json::parse(run(folder, "solve small.toml --json").out);
  const std::string table = run(folder, "solve small.toml --capacitance").out;
  for (const json& conductor : answer["conductors"])
    CHECK(contains(table, fmt::format("{:.7g}", conductor["potential"].get<double>())));
  CHECK(contains(table, fmt::format("{:.7g} J", answer["energy"].get<double>())));
  CHECK(contains(table, "capacitance matrix"));
  CHECK_FALSE(answer.contains("capacitance"));
}

TEST_CASE("multipole method: solve agrees with a grid; explain predicts unknowns") {
  const Folder folder;
  folder.write("grid.toml", small_scene_with("tolerance = 1e-8"));
  folder.write("small.toml", small_scene_with("method = \"multipole\""));
  const json grid = json::parse(run(folder, "solve grid.toml --json").out);
  const Ended result = run(folder, "solve small.toml --json --capacitance --field small.vtkhdf");
  REQUIRE(result.status == 0);
  const json answer = json::parse(result.out);
  CHECK(answer["method"] == "multipole");
  // With a radius of 4 cells and a gap of 16 cells the grid's error is within 0.1 %.
  for (const int i : {0, 1})
    CHECK(answer["conductors"][i]["potential"].get<double>() ==
          near(grid["conductors"][i]["potential"].get<double>(), 1e-3));
  CHECK(answer["energy"].get<double>() == near(grid["energy"].get<double>(), 1e-3));
  CHECK(answer["unknowns"].get<long>() < 200);  // About 40 per disk, compared with 64^2 for the grid.
  CHECK(std::filesystem::exists(folder / "small.vtkhdf"));
  const Ended explained = run(folder, "explain small.toml");
  CHECK(contains(explained.out, fmt::format(" {}:", answer["unknowns"].get<long>())));
  CHECK(contains(explained.out, "spectral"));
  CHECK(contains(explained.out, "refused"));  // A run is refused because no contact force separates the disks.
  check_refused(run(folder, "run small.toml"), "[effects.hertz_contact]");
}

TEST_CASE("field.accuracy: solve, explain and run report the chosen field method") {
  const Folder folder;
  folder.write("grid.toml", small_scene_with_accuracy("1e-2\n  method = \"cut-cell\""));
  folder.write("any.toml", small_scene_with_accuracy("1e-6"));
  const json by_grid = json::parse(run(folder, "solve grid.toml --json").out);
  const json exact = json::parse(run(folder, "solve any.toml --json").out);
  CHECK(by_grid["method"] == "cut-cell");
  CHECK(exact["method"] == "multipole");
  for (const json& answer : {by_grid, exact})
    CHECK(answer["accuracy"]["estimated_error"].get<double>() <= answer["accuracy"]["asked"].get<double>());
  // The electrode side is at 0 V: the largest potential is the largest difference.
  const double held = exact["conductors"][0]["potential"];
  CHECK(by_grid["conductors"][0]["potential"].get<double>() == near(held, 1e-2));
  CHECK(contains(run(folder, "solve grid.toml").out, "chosen      cut-cell"));
  const std::string explained = run(folder, "explain grid.toml --petsc -options_left -nobodys_option").out;
  CHECK(contains(explained, "accuracy             0.01: some "));
  CHECK_FALSE(contains(explained, "nobodys_option"));  // PETSc is not started.
  // Multipoles suffice for `solve`. A run, in which no contact force separates these disks, would choose a grid.
  CHECK_FALSE(contains(run(folder, "explain any.toml").out, "refused"));
  // Any effect besides the field makes the scene a run, also leakage alone.
  folder.write("leaky.toml", small_scene_with_accuracy("1e-2\n  [effects.leakage]\n  conductivity = 1e-12"));
  CHECK(contains(run(folder, "explain leaky.toml").out, "method               cut-cell"));
  folder.write("moving.toml",
               small_scene_with_accuracy(
                   "1e-2\n  method = \"cut-cell\"\n[output]\nevery = 1e-4\npicture = false\n[stop]\ntime = 1e-4"));
  const Ended result = run(folder, "run moving.toml");
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(contains(result.out, "field          cut-cell, "));
  CHECK(contains(result.out, "field error    at most "));
}

TEST_CASE("field.accuracy out of reach: solve, explain and run refuse the scene") {
  const Folder folder;
  // A gap of 1e-4 of the box.
  std::string close = small_scene_with_accuracy("1e-9\n  method = \"cut-cell\"");
  close.replace(close.find("[11e-3, 8e-3]"), 13, "[7.0016e-3, 8e-3]");
  folder.write("close.toml", close);
  for (const std::string command : {"solve", "explain", "run"})
    check_refused(run(folder, command + " close.toml"), "field.accuracy = 1e-09 cannot be met");
}

TEST_CASE("multipole method: solve, explain and run refuse a ring electrode") {
  const Folder folder;
  folder.write("ring.toml", small_scene_with("method = \"multipole\"\n[[electrode]]\nname = \"rim\"\nshape = \"ring\"\n"
                                             "centre = [8e-3, 8e-3]\nradius = 8e-3\npotential = 0.0"));
  for (const std::string command : {"solve", "explain", "run"})
    check_refused(run(folder, command + " ring.toml"), "\"rim\" is a ring");
}

TEST_CASE("field.device = \"cuda\": refused for the multipole method") {
  const Folder folder;
  folder.write("small.toml", small_scene_with("method = \"multipole\""));
  for (const std::string command : {"solve", "explain"})
    check_refused(run(folder, command + " small.toml --device cuda"), "field.device = \"cuda\"");
  folder.write("asking.toml", small_scene_with_accuracy("1e-3\n  method = \"multipole\""));
  check_refused(run(folder, "solve asking.toml --device cuda"), "field.device = \"cuda\"");
  check_refused(run(folder, "solve small.toml --device gpu"), "--device");
  CHECK(run(folder, "solve small.toml --device cpu").status == 0);
}

TEST_CASE("solve --petsc: the options that follow are passed to PETSc") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  CHECK(contains(run(folder, "solve small.toml --petsc -field_ksp_view").out, "KSP Object"));
  const Ended result = run(folder, "solve small.toml --petsc -field_ksp_type nonsense");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "nonsense"));
}

TEST_CASE("solve --petsc: other solvers on a grid give the default's energy") {
  // An insulating box, whose matrix is singular, and a grounded one.
  const Folder folder;
  std::string neutral = "[domain]\nsize = [0.02, 0.02]\n[medium]\nrelative_permittivity = 4.7\n";
  for (const std::string sign : {"", "-"})
    neutral += "[[conductor]]\nposition = [" + std::string(sign.empty() ? "0.006" : "0.014") +
               ", 0.01]\nradius = 1e-3\ncharge = " + sign + "1e-10\n";
  folder.write("neutral.toml", neutral + "[effects.floating_conductors]\n[field]\ncells = 128\n");
  folder.write("small.toml", small_scene);
  for (const std::string scene : {"neutral.toml", "small.toml"}) {
    const json expected = json::parse(run(folder, "solve " + scene + " --json").out);
    for (const std::string method : {"minres", "bcgs", "gmres", "tfqmr", "symmlq", "bicg", "chebyshev"}) {
      CAPTURE(scene);
      CAPTURE(method);
      const Ended ended = run(folder, "solve " + scene + " --json --petsc -field_ksp_type " + method);
      REQUIRE_MESSAGE(ended.status == 0, ended.err);
      const json found = json::parse(ended.out);
      CHECK(found["residual"] <= 1e-8);
      CHECK(found["energy"].get<double>() == doctest::Approx(expected["energy"].get<double>()).epsilon(1e-7));
    }
  }
}

TEST_CASE("solve --petsc: other solvers for spheres give the default's energy") {
  const Folder folder;
  std::filesystem::copy(source_folder() + "/scenes/pair-3d.toml", folder / "pair.toml");
  const json expected = json::parse(run(folder, "solve pair.toml --json --capacitance").out);
  for (const std::string method : {"minres", "bcgs", "gmres", "symmlq", "preonly", "chebyshev", "bicg",
                                   "cg -spheres_ksp_convergence_test default"}) {
    CAPTURE(method);
    const Ended ended = run(folder, "solve pair.toml --json --capacitance --petsc -spheres_ksp_type " + method);
    REQUIRE_MESSAGE(ended.status == 0, ended.err);
    const json found = json::parse(ended.out);
    CHECK(found["residual"] <= expected["accuracy"]["tolerance"]);
    CHECK(found["energy"].get<double>() == doctest::Approx(expected["energy"].get<double>()).epsilon(1e-5));
  }
}

TEST_CASE("solve --field: writes an HDF5 file, replaces one only with --overwrite") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  CHECK(run(folder, "solve small.toml --field field.vtkhdf").status == 0);
  const auto is_hdf5 = [&] { return contains(text_of(folder / "field.vtkhdf").substr(0, 4), "HDF"); };
  CHECK(is_hdf5());

  folder.write("field.vtkhdf", "something dear");
  check_refused(run(folder, "solve small.toml --field field.vtkhdf"), "give --overwrite");
  CHECK(text_of(folder / "field.vtkhdf") == "something dear");
  CHECK(run(folder, "solve small.toml --field field.vtkhdf --overwrite").status == 0);
  CHECK(is_hdf5());
  check_refused(run(folder, "solve small.toml --field no/such/folder/field.vtkhdf"), "no/such/folder");
  // The existing file is the command's own.
  CHECK(run(folder, "solve small.toml --field field.vtkhdf --overwrite").status == 0);
}

TEST_CASE("solve --overwrite: replaces neither the scene file nor a result") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  folder.write("run.toml", small_scene + "[stop]\ntime = 1e-6\n[output]\npicture = false\n[effects.stokes_drag]\n");
  REQUIRE(run(folder, "run run.toml --quiet --set medium.viscosity=0.7").status == 0);
  const std::string scene = text_of(folder / "small.toml"), result = text_of(folder / "run.h5");
  check_refused(run(folder, "solve small.toml --field small.toml --overwrite"), "is an input file");
  check_refused(run(folder, "solve small.toml --field run.h5 --overwrite"), "run.h5 is a result");
  check_refused(run(folder, "solve small.toml --out a.png --field a.png"), "cannot be written twice");
  CHECK(text_of(folder / "small.toml") == scene);
  CHECK(text_of(folder / "run.h5") == result);
}

TEST_CASE("solve with electrodes only: charge and capacitance of a plate capacitor") {
  const Folder folder;
  folder.write("plates.toml", plates);
  const double capacitance = 4e-11 * 16e-3 * 2e-3 / 8e-3;  // The field is uniform: exact within the solver's tolerance.
  const json answer = json::parse(run(folder, "solve plates.toml --capacitance --json").out);
  CHECK(answer["conductors"].empty());
  CHECK(answer["depth"] == 2e-3);
  CHECK(answer["units"]["charge"] == "C");
  REQUIRE(answer["electrodes"].size() == 2);
  CHECK(answer["electrodes"][0]["name"] == "the bottom side of the domain");
  CHECK(answer["electrodes"][1]["charge"].get<double>() == near(100 * capacitance, 1e-6));
  const json& matrix = answer["capacitance"]["matrix"];
  CHECK(matrix[0][0].get<double>() == near(capacitance, 1e-6));
  CHECK(matrix[0][1].get<double>() == near(-capacitance, 1e-6));
  const std::string table = run(folder, "solve plates.toml --out plates.png").out;
  CHECK(text_of(folder / "plates.png").starts_with("\x89PNG"));
  check_refused(run(folder, "solve plates.toml --out plates.png"), "give --overwrite");
  check_refused(run(folder, "solve plates.toml --out plates.gif"), "must end in .png, .pdf or .svg");
  check_refused(run(folder, "solve plates.toml --field ''"), "--field: the value is empty");
  CHECK(contains(table, "the top side of the domain"));
  CHECK(contains(table, "depth       0.002 m"));
  CHECK(contains(run(folder, "explain plates.toml").out, "none: without conductors nothing moves"));
  check_refused(run(folder, "run plates.toml"), "`lichtenberg solve` solves its field");
  folder.write("moving.toml", plates + "[effects.stokes_drag]\n");
  check_refused(run(folder, "solve moving.toml --set medium.viscosity=1"), "the scene has no conductors");
  folder.write("empty.toml",
               replaced(replaced(plates, "top = { potential = 100.0 }", ""), "bottom = { potential = 0.0 }", ""));
  check_refused(run(folder, "solve empty.toml"), "there is no field");
}

TEST_CASE("solve with four disk electrodes only: their charges sum to zero") {
  const Folder folder;
  std::string scene = "domain = { size = [16e-3, 16e-3] }\nmedium = { permittivity = 4e-11 }\n";
  for (const auto& [x, y, potential] : {std::tuple{4, 4, 0}, {12, 4, 50}, {4, 12, 100}, {12, 12, -30}})
    scene += fmt::format("[[electrode]]\nshape = \"disk\"\ncentre = [{}e-3, {}e-3]\nradius = 1e-3\npotential = {}\n", x,
                         y, potential);
  folder.write("four.toml", scene + "[effects.floating_conductors]\n");
  const json answer = json::parse(run(folder, "solve four.toml --json").out);
  double sum = 0, largest = 0;
  for (const json& electrode : answer["electrodes"]) {
    const double charge = electrode["charge"];
    sum += charge;
    largest = std::max(largest, std::abs(charge));
  }
  CHECK(answer["electrodes"].size() == 4);
  // An insulated box contains only the charges of its bodies; the tolerance is 1e-8.
  CHECK(std::abs(sum) < 1e-7 * largest);
  CHECK(answer["depth"] == 1);
}

}  // namespace commands_solve_test
