// The command line as a user meets it: the built program, its exit status and what it prints.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <tuple>

#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"
#include "tests/program.hpp"
#include "tests/source_folder.hpp"

using namespace lichtenberg;

namespace {

using nlohmann::json;

const std::string scenes = source_folder() + "/scenes/";

Ended run(const Folder& folder, const std::string& arguments) { return run_program(folder, arguments); }
Ended run(const std::string& arguments) { return run(Folder(), arguments); }

bool one_sentence(const std::string& text) {
  return text.starts_with("lichtenberg: ") && text.find('\n') == text.size() - 1;
}

/// Equal but for a relative error, however small the numbers are: doctest's own scale of 1 makes all charges equal.
doctest::Approx near(double value, double error) { return doctest::Approx(value).epsilon(error).scale(0); }

void check_refused(const Ended& result, const std::string& part) {
  INFO(result.err);
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK(one_sentence(result.err));
  CHECK(contains(result.err, part));
}

/// A small scene whose field takes milliseconds.
const std::string small_scene = R"(
  [domain]
  size = [16e-3, 16e-3]
  bottom = { potential = 0.0 }
  [medium]
  permittivity = 4e-11
  [[conductor]]
  position = [5e-3, 8e-3]
  radius = 1e-3
  charge = 1e-10
  [[conductor]]
  position = [11e-3, 8e-3]
  radius = 1e-3
  [effects.floating_conductors]
  [field]
  cells = 64
)";

}  // namespace

TEST_CASE("a wrong command line is one sentence and status 2") {
  check_refused(run(""), "lichtenberg help");
  check_refused(run("slove scene.toml"), "`solve`");
  check_refused(run("solve"), "SCENE is required");
  check_refused(run("solve a.toml b.toml"), "b.toml");
  check_refused(run("solve --jsno a.toml"), "--jsno");
  check_refused(run("help scne"), "`scene`");
}

TEST_CASE("a scene that cannot be used is one sentence and status 2") {
  check_refused(run("solve nowhere.toml"), "nowhere.toml");
  check_refused(run("explain nowhere.toml"), "nowhere.toml");
  const Folder folder;
  folder.write("typo.toml", small_scene + "  tolerence = 1e-6\n");
  check_refused(run(folder, "solve typo.toml"), "tolerance");
  check_refused(run(folder, "explain typo.toml"), "tolerance");
}

TEST_CASE("solve in space says which charges it doesn't know, and refuses another device") {
  const Folder folder;
  folder.write("edge.toml",
               "domain = { size = [1.0, 1.0, 1.0], left = { potential = 0.0 }, front = { potential = 0.0 } }\n"
               "medium = { permittivity = 1.0 }\n[[conductor]]\nposition = [0.5, 0.5, 0.5]\nradius = 0.1\n"
               "charge = 1.0\n[effects.floating_conductors]\n");
  CHECK(contains(run(folder, "solve edge.toml").out, "unknown  the left side"));
  CHECK(contains(run(folder, "solve edge.toml --json").out, "\"charge\": null"));
  check_refused(run(folder, "solve edge.toml --device cuda"), "spheres");
}

TEST_CASE("solve refuses a scene without a field, and charge that has nowhere to go") {
  const Folder folder;
  folder.write("neutral.toml",
               "[domain]\nsize = [1e-2, 1e-2]\n[[conductor]]\nposition = [5e-3, 5e-3]\nradius = 1e-3\n");
  check_refused(run(folder, "solve neutral.toml"), "[effects.floating_conductors]");
  std::string insulated = small_scene;
  insulated.erase(insulated.find("  bottom"), insulated.find("  [medium]") - insulated.find("  bottom"));
  folder.write("insulated.toml", insulated);
  check_refused(run(folder, "solve insulated.toml"), "charge");
}

TEST_CASE("help explains the program, a command and the scene") {
  const Ended program = run("help");
  CHECK(program.status == 0);
  for (const std::string command : {"run", "solve", "explain", "plot", "film", "view", "export", "analyse", "network",
                                    "work-precision", "ensemble", "help", "--petsc"})
    CHECK(contains(program.out, command));
  CHECK(contains(run("help solve").out, "--capacitance"));
  CHECK(run("solve --help").out == run("help solve").out);
  CHECK(run("help scene").out == lichtenberg::scene_help());
}

TEST_CASE("--version names the commit") {
  const Ended result = run("--version");
  CHECK(result.status == 0);
  CHECK(result.out.starts_with("lichtenberg 0.1.0 ("));
}

TEST_CASE("solve --json: the two disks of the shipped scene") {
  const Ended result = run("solve " + scenes + "two-disks.toml --json --capacitance");
  REQUIRE(result.status == 0);
  const json answer = json::parse(result.out);
  std::vector<std::string> fields;
  for (const auto& [key, value] : answer.items()) fields.push_back(key);
  CHECK(fields == std::vector<std::string>{"capacitance", "conductors", "depth", "electrodes", "energy", "iterations",
                                           "method", "residual", "seconds", "units", "unknowns", "work"});
  REQUIRE(answer["conductors"].size() == 2);
  const json& held = answer["conductors"][0];
  const json& floating = answer["conductors"][1];
  for (const std::string field : {"position", "radius", "group", "potential", "charge", "force"})
    CHECK(held.contains(field));
  for (const std::string phase : {"setup", "solve", "forces"}) CHECK(answer["seconds"].contains(phase));

  // D 6.37 with d/2R = 2 and the scene's depth 2R: 652.1 V if there were no walls, which are within 1 % of that.
  const double permittivity = 4.7 * 8.8541878128e-12, radius = 0.775e-3, charge = 1e-10;
  const double capacitance = 2 * radius * std::numbers::pi * permittivity / std::acosh(2.0);
  CHECK(held["potential"].get<double>() == 0);
  CHECK(floating["potential"].get<double>() == near(charge / capacitance, 0.01));
  CHECK(held["group"] != floating["group"]);
  // Flux balance: charge goes nowhere else; the solver's relative tolerance is 1e-10.
  CHECK(floating["charge"].get<double>() == near(charge, 1e-9));
  CHECK(held["charge"].get<double>() == near(-charge, 1e-9));
  // Opposite charges attract, and with equal strength: the walls are symmetric to both.
  CHECK(held["force"][0].get<double>() > 0);
  CHECK(floating["force"][0].get<double>() == near(-held["force"][0].get<double>(), 1e-6));
  // W = Q phi / 2 with the other conductor at zero.
  CHECK(answer["energy"].get<double>() == near(0.5 * charge * floating["potential"].get<double>(), 1e-8));

  const json& matrix = answer["capacitance"]["matrix"];
  CHECK(answer["capacitance"]["groups"] == json({"ground", "conductor 1"}));
  CHECK(matrix[1][1].get<double>() == near(charge / floating["potential"].get<double>(), 1e-8));
  CHECK(matrix[0][1].get<double>() == near(-matrix[1][1].get<double>(), 1e-8));
}

TEST_CASE("solve's table has the numbers of its JSON") {
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

/// The same with a line added to its [field], which comes last.
std::string small_scene_with(const std::string& line) { return small_scene + "  " + line + "\n"; }

TEST_CASE("solve and explain by multipoles") {
  const Folder folder;
  folder.write("grid.toml", small_scene_with("tolerance = 1e-8"));
  folder.write("small.toml", small_scene_with("method = \"multipole\""));
  const json grid = json::parse(run(folder, "solve grid.toml --json").out);
  const Ended result = run(folder, "solve small.toml --json --capacitance --field small.vtkhdf");
  REQUIRE(result.status == 0);
  const json answer = json::parse(result.out);
  CHECK(answer["method"] == "multipole");
  // Radius 4 cells, gap 16 cells: the grid's error is within .1 %.
  for (const int i : {0, 1})
    CHECK(answer["conductors"][i]["potential"].get<double>() ==
          near(grid["conductors"][i]["potential"].get<double>(), 1e-3));
  CHECK(answer["energy"].get<double>() == near(grid["energy"].get<double>(), 1e-3));
  CHECK(answer["unknowns"].get<long>() < 200);  // some 40 a disk, against 64^2 of the grid
  CHECK(std::filesystem::exists(folder / "small.vtkhdf"));
  const Ended explained = run(folder, "explain small.toml");
  CHECK(contains(explained.out, fmt::format(" {}:", answer["unknowns"].get<long>())));
  CHECK(contains(explained.out, "spectral"));
  CHECK(contains(explained.out, "refused"));  // a run: nothing keeps the disks apart
  check_refused(run(folder, "run small.toml"), "[effects.hertz_contact]");
}

/// The small scene with its [field] asking for an accuracy in place of cells.
std::string small_scene_asking(const std::string& accuracy) {
  std::string scene = small_scene;
  scene.replace(scene.find("cells = 64"), 10, "accuracy = " + accuracy);
  return scene;
}

TEST_CASE("solve, explain and run say what they chose for an accuracy") {
  const Folder folder;
  folder.write("grid.toml", small_scene_asking("1e-2\n  method = \"cut-cell\""));
  folder.write("any.toml", small_scene_asking("1e-6"));
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
  CHECK_FALSE(contains(explained, "nobodys_option"));  // PETSc is not started
  // Multipoles will do for `solve`; a run, in which nothing keeps these disks apart, would choose a grid.
  CHECK_FALSE(contains(run(folder, "explain any.toml").out, "refused"));
  // Any effect beside the field makes a run of the scene, leakage alone too.
  folder.write("leaky.toml", small_scene_asking("1e-2\n  [effects.leakage]\n  conductivity = 1e-12"));
  CHECK(contains(run(folder, "explain leaky.toml").out, "method               cut-cell"));
  folder.write("moving.toml",
               small_scene_asking(
                   "1e-2\n  method = \"cut-cell\"\n[output]\nevery = 1e-4\npicture = false\n[stop]\ntime = 1e-4"));
  const Ended result = run(folder, "run moving.toml");
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(contains(result.out, "field          cut-cell, "));
  CHECK(contains(result.out, "field error    at most "));
}

TEST_CASE("an accuracy that cannot be met is refused with what can") {
  const Folder folder;
  // A gap of a ten-thousandth of the box.
  std::string close = small_scene_asking("1e-9\n  method = \"cut-cell\"");
  close.replace(close.find("[11e-3, 8e-3]"), 13, "[7.0016e-3, 8e-3]");
  folder.write("close.toml", close);
  for (const std::string command : {"solve", "explain", "run"})
    check_refused(run(folder, command + " close.toml"), "an accuracy of ");
}

TEST_CASE("other shapes than disks are refused by multipoles before any work") {
  const Folder folder;
  folder.write("ring.toml", small_scene_with("method = \"multipole\"\n[[electrode]]\nname = \"rim\"\nshape = \"ring\"\n"
                                             "centre = [8e-3, 8e-3]\nradius = 8e-3\npotential = 0.0"));
  for (const std::string command : {"solve", "explain", "run"})
    check_refused(run(folder, command + " ring.toml"), "\"rim\" is a ring");
}

TEST_CASE("a device that the method cannot use is refused") {
  const Folder folder;
  folder.write("small.toml", small_scene_with("method = \"multipole\""));
  for (const std::string command : {"solve", "explain"})
    check_refused(run(folder, command + " small.toml --device cuda"), "field.device = \"cuda\"");
  folder.write("asking.toml", small_scene_asking("1e-3\n  method = \"multipole\""));
  check_refused(run(folder, "solve asking.toml --device cuda"), "field.device = \"cuda\"");
  check_refused(run(folder, "solve small.toml --device gpu"), "--device");
  CHECK(run(folder, "solve small.toml --device cpu").status == 0);
  for (const std::string resistor :
       {"[[electrode]]\nshape = \"disk\"\ncentre = [8e-3, 14e-3]\nradius = 1e-3\npotential = 1.0\n"
        "series_resistance = 1e9\n",
        "[effects.contact_discharge]\n[effects.contact_resistance]\nresistance = 1e9\n"}) {
    folder.write("resistor.toml", small_scene + resistor + "[stop]\ntime = 1e-3\n[output]\nevery = 1e-3\n");
    check_refused(run(folder, "run resistor.toml --device cuda"),
                  "field.device = \"cuda\" is not allowed in a run with resistors: \"cpu\" is");
    CHECK_FALSE(std::filesystem::exists(folder / "resistor.h5"));  // refused before anything is written
  }
}

TEST_CASE("solve passes what follows --petsc to PETSc") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  CHECK(contains(run(folder, "solve small.toml --petsc -field_ksp_view").out, "KSP Object"));
  const Ended result = run(folder, "solve small.toml --petsc -field_ksp_type nonsense");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "nonsense"));
}

TEST_CASE("solve --field writes a file, and replaces one only if told") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  CHECK(run(folder, "solve small.toml --field field.vtkhdf").status == 0);
  const auto is_hdf5 = [&] { return contains(text_of(folder / "field.vtkhdf").substr(0, 4), "HDF"); };
  CHECK(is_hdf5());

  folder.write("field.vtkhdf", "something dear");
  check_refused(run(folder, "solve small.toml --field field.vtkhdf"), "allow --overwrite");
  CHECK(text_of(folder / "field.vtkhdf") == "something dear");
  CHECK(run(folder, "solve small.toml --field field.vtkhdf --overwrite").status == 0);
  CHECK(is_hdf5());
  check_refused(run(folder, "solve small.toml --field no/such/folder/field.vtkhdf"), "no/such/folder");
}

TEST_CASE("output that cannot be written is a failure") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const std::string arguments : {"solve small.toml --json", "explain small.toml", "help scene"}) {
    const Ended result = run(folder, arguments + " >/dev/full");
    CHECK(result.status == 1);
    CHECK(contains(result.err, "No space left on device"));  // in the words of whoever noticed: {fmt} or we
  }
}

TEST_CASE("a run whose conductor leaves the domain is one sentence and status 1") {
  const Folder folder;
  // 1 m/s through 7 mm of fluid, nothing that holds it back.
  folder.write(
      "lost.toml",
      "[domain]\nsize = [1e-2, 1e-2]\n[medium]\nrelative_permittivity = 2\n[[conductor]]\nposition = [3e-3, 5e-3]\n"
      "radius = 1e-3\nvelocity = [1, 0]\n[effects.floating_conductors]\n[field]\ncells = 32\n[stop]\ntime = 0.1\n");
  const Ended result = run(folder, "run lost.toml --quiet");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "conductor 0 has left the domain"));
  CHECK(contains(result.err, "[effects.wall_contact]"));
}

TEST_CASE("explain names every effect, the unknowns that solve has, and does not start PETSc") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  // PETSc, if it were started, would end with a list of the options that nobody used.
  const Ended result = run(folder, "explain small.toml --petsc -options_left -nobodys_option");
  REQUIRE(result.status == 0);
  CHECK_FALSE(contains(result.out + result.err, "nobodys_option"));
  const std::size_t left_out = result.out.find("left out");
  for (const auto& effect : lichtenberg::effects::summarize_effects({}))
    CHECK((result.out.find(effect.name) < left_out) == (effect.name == "floating_conductors"));
  const json answer = json::parse(run(folder, "solve small.toml --json").out);
  CHECK(contains(result.out, fmt::format(" {}:", answer["unknowns"].get<long>())));
}

TEST_CASE("explain of a grid beyond this machine's memory says what it would take") {
  const Folder folder;
  // 2^30 cells, some 100 bytes each.
  folder.write(
      "huge.toml",
      "[domain]\nsize = [1e-2, 1e-2]\n[medium]\nrelative_permittivity = 2\n[[conductor]]\nposition = [5e-3, 5e-3]\n"
      "radius = 1e-7\n[effects.floating_conductors]\n[field]\ncells = 32768\n");
  const Ended result = run(folder, "explain huge.toml");
  CHECK(result.status == 0);
  CHECK(contains(result.out, "at most 1073741824"));
  CHECK(contains(result.out, "0.328 cells, less than one"));  // 1e-7 m / (1e-2 m / 32768)
}

TEST_CASE("explain of a neutral scene says that nothing electric is touched") {
  const Folder folder;
  folder.write("neutral.toml",
               "[domain]\nsize = [1e-2, 1e-2]\n[[conductor]]\nposition = [5e-3, 5e-3]\nradius = 1e-3\n");
  const Ended result = run(folder, "explain neutral.toml");
  CHECK(result.status == 0);
  CHECK(contains(result.out, "charges, field, neighbour list"));
  CHECK_FALSE(contains(result.out, "unknowns"));
}

TEST_CASE("plot refuses what is no result file") {
  const Folder folder;
  const Ended missing = run(folder, "plot nowhere.h5");
  CHECK(missing.status == 2);
  CHECK(contains(missing.err, "nowhere.h5"));
  folder.write("text.h5", "no HDF5");
  CHECK(run(folder, "plot text.h5").status == 2);
  CHECK_FALSE(std::filesystem::exists(folder / "text.png"));
}

TEST_CASE("work-precision prints a table and prices, draws, and replaces nothing unless told") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const std::string command = "work-precision small.toml --methods cut-cell,relaxation --sizes 32 --json small.json";
  const Ended first = run(folder, command);
  INFO(first.err);
  REQUIRE(first.status == 0);
  for (const std::string part : {"S = 32, tolerance = 1e-08", "price list", "the multipole method", "versions"})
    CHECK(contains(first.out, part));
  const std::string picture = text_of(folder / "small-work-precision.png");
  CHECK(picture.starts_with("\x89PNG"));
  CHECK(json::parse(text_of(folder / "small.json"))["points"].size() == 8);
  check_refused(run(folder, command), "small-work-precision.png exists");
  check_refused(run(folder, command + " --output other.png"), "small.json exists");
  CHECK(text_of(folder / "small-work-precision.png") == picture);
}

TEST_CASE("work-precision refuses methods, sizes and pictures that are none") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  check_refused(run(folder, "work-precision small.toml --methods sor"), "sor");
  check_refused(run(folder, "work-precision small.toml --sizes 4"), "--sizes 4");
  check_refused(run(folder, "work-precision small.toml --time --sizes 64"), "--sizes");
  check_refused(run(folder, "work-precision small.toml --seconds 0"), "--seconds");
  check_refused(run(folder, "work-precision small.toml --output small.gif"), "small.gif");
  check_refused(run(folder, "work-precision small.toml --output a.png --json ./a.png"), "--json ./a.png");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 3);  // the scene, out, err
}

TEST_CASE("--set changes keys of any scene that a command reads, texts without their quotes too") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const Ended explained = run(folder, "explain small.toml --set field.cells=32 --set 'medium.depth = 2e-3'");
  CHECK(explained.status == 0);
  CHECK(contains(explained.out, "32 x 32 cells"));
  CHECK(contains(run(folder, "explain small.toml --set field.method=multipole").out, "multipole"));
  const json plain = json::parse(run(folder, "solve small.toml --json").out);
  const json deep = json::parse(run(folder, "solve small.toml --json --set medium.depth=4e-3").out);
  CHECK(deep["energy"].get<double>() == near(0.5 * plain["energy"].get<double>(), 1e-9));  // the same charge, depth x 2
  check_refused(run(folder, "solve small.toml --set field.cell=32"), "the nearest known key is field.cells");
  check_refused(run(folder, "solve small.toml --set field.cells=-1"), "small.toml: field.cells = -1 is not allowed");
  check_refused(run(folder, "solve small.toml --set conductor[1].radius=0"), "conductor.radius = 0 is not allowed");
  check_refused(run(folder, "solve small.toml --set field.accuracy=1e-3"), "field.cells is chosen for field.accuracy");
  check_refused(run(folder, "solve small.toml --set field.accuracy=1e-3 --set field.cells=32"),
                "small.toml: field.cells is chosen for field.accuracy");
  check_refused(run(folder, "solve small.toml --set field.cells"), "a key and its value are wanted");
}

TEST_CASE("a run starts from a frame of another, with other settings") {
  const Folder folder;
  folder.write("small.toml", small_scene + R"(
  [effects.stokes_drag]
  [output]
  every = 0.01
  picture = false
  [stop]
  time = 0.05
)");
  const std::string drag = " --quiet --set medium.viscosity=0.7";
  REQUIRE(run(folder, "run small.toml --out first.h5" + drag).status == 0);
  const Ended second = run(folder, "run small.toml --out second.h5 --from first.h5 --frame 3" + drag);
  REQUIRE_MESSAGE(second.status == 0, second.err);
  const auto rows = [&](const std::string& file, const std::string& column) {
    return hdf5::get<double>(hdf5::load(folder / file), "particles/conductors/" + column + "/value");
  };
  for (const std::string column : {"position", "charge", "velocity"}) {
    const std::vector<double> first = rows("first.h5", column), then = rows("second.h5", column);
    const std::size_t row = first.size() / 6;  // frames
    for (std::size_t k = 0; k < row; ++k) CHECK(then[k] == first[3 * row + k]);
  }
  check_refused(run(folder, "run small.toml --out third.h5 --from first.h5 --frame 6" + drag), "frames 0 to 5");
  check_refused(run(folder, "run small.toml --out third.h5 --frame 1" + drag), "--from");
  check_refused(run(folder, "run small.toml --out third.h5 --from first.h5 --set conductor[0].radius=0.9e-3" + drag),
                "body 0 has a radius of 0.001");
  check_refused(run(folder, "run small.toml --out second.h5 --resume" + drag), "with the same --from and --frame");
  CHECK(run(folder, "run small.toml --out second.h5 --resume --from first.h5 --frame 3" + drag).status == 0);
}

TEST_CASE("a box in space has three lengths, on the screen and in the file") {
  const Folder folder;
  folder.write("cube.toml", R"(
  domain = { size = [0.01, 0.02, 0.03] }
  conductor = [{ position = [5e-3, 5e-3, 5e-3], radius = 1e-3 }]
  output = { picture = false, every = 0.1 }
  stop = { time = 0.1 }
)");
  CHECK(contains(run(folder, "explain cube.toml").out, "0.01 m x 0.02 m x 0.03 m"));
  REQUIRE(run(folder, "run cube.toml --quiet").status == 0);
  CHECK(hdf5::get<double>(hdf5::load(folder / "cube.h5"), "scene/domain/size") ==
        std::vector<double>{0.01, 0.02, 0.03});
}

/// Two sides of a box as the plates of a capacitor, 16 x 8 mm, 2 mm deep.
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

TEST_CASE("electrodes alone are a scene: a plate capacitor has the charges and the capacitance that it must") {
  const Folder folder;
  folder.write("plates.toml", plates);
  const double capacitance = 4e-11 * 16e-3 * 2e-3 / 8e-3;  // the field is uniform: exact but for the solver's tolerance
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
  const std::string table = run(folder, "solve plates.toml --picture plates.png").out;
  CHECK(text_of(folder / "plates.png").starts_with("\x89PNG"));
  check_refused(run(folder, "solve plates.toml --picture plates.png"), "allow --overwrite");
  check_refused(run(folder, "solve plates.toml --picture plates.gif"), "must end in .png, .pdf or .svg");
  check_refused(run(folder, "solve plates.toml --field ''"), "--field: the value is empty");
  CHECK(contains(table, "the top side of the domain"));
  CHECK(contains(table, "depth       0.002 m"));
  CHECK(contains(run(folder, "explain plates.toml").out, "none: without conductors nothing moves"));
  check_refused(run(folder, "run plates.toml"), "`lichtenberg solve` solves its field");
  folder.write("moving.toml", plates + "[effects.stokes_drag]\n");
  check_refused(run(folder, "solve moving.toml --set medium.viscosity=1"), "the scene has no conductors");
  folder.write("empty.toml",
               replaced(replaced(plates, "top = { potential = 100.0 }", ""), "bottom = { potential = 0.0 }", ""));
  check_refused(run(folder, "solve empty.toml"), "nothing makes a field");
}

namespace {

const std::string plates_in_space = R"(
  [domain]
  size = [8e-3, 10e-3, 12e-3]
  left = { potential = 100.0 }
  right = { potential = -50.0 }
  [medium]
  permittivity = 4e-11
  [[conductor]]
  position = [3e-3, 5e-3, 6e-3]
  radius = 1e-3
  charge = 1e-11
  [effects.floating_conductors]
  [field]
  accuracy = 1e-8
)";

}  // namespace

TEST_CASE("a sphere between two plates: the capacitance matrix has the plates, and says what charges they have") {
  const Folder folder;
  folder.write("plates.toml", plates_in_space);
  const json answer = json::parse(run(folder, "solve plates.toml --capacitance --json").out);
  const json& matrix = answer["capacitance"]["matrix"];
  CHECK(answer["capacitance"]["groups"] ==
        json({"conductor 0", "the left side of the domain", "the right side of the domain"}));
  const double potential[] = {answer["conductors"][0]["potential"].get<double>(), 100, -50};
  const double charge[] = {1e-11, answer["electrodes"][0]["charge"].get<double>(),
                           answer["electrodes"][1]["charge"].get<double>()};
  for (int i = 0; i < 3; ++i) {
    double sum = 0, made = 0;
    for (int j = 0; j < 3; ++j) {
      const double c = matrix[i][j].get<double>();
      sum += c, made += c * potential[j];
      CHECK(c == near(matrix[j][i].get<double>(), 1e-6));
    }
    CHECK(std::abs(sum) < 1e-7 * matrix[i][i].get<double>());  // all else insulates: one potential has no field
    CHECK(made == near(charge[i], 1e-6));
  }
  // Sides that meet have one charge.
  const std::string right = "right = { potential = -50.0 }";
  std::string edge = plates_in_space;
  edge.replace(edge.find(right), right.size(), "right = { potential = 100.0 }\n top = { potential = 100.0 }");
  folder.write("edge.toml", edge);
  const json joined = json::parse(run(folder, "solve edge.toml --capacitance --json").out);
  CHECK(joined["capacitance"]["groups"] == json({"conductor 0", "the left, right, top sides of the domain"}));
  CHECK(joined["electrodes"].back()["charge"].get<double>() == near(-1e-11, 1e-9));
  CHECK(joined["electrodes"][0]["charge"].is_null());
  CHECK(joined["capacitance"]["matrix"][0][1].get<double>() ==
        near(-joined["capacitance"]["matrix"][0][0].get<double>(), 1e-7));
}

TEST_CASE("explain says which harmonics spheres take, and what they cost; work-precision sweeps them") {
  const Folder folder;
  folder.write("plates.toml", plates_in_space);
  const std::string explained = run(folder, "explain plates.toml").out;
  const json solved = json::parse(run(folder, "solve plates.toml --json").out);
  CHECK(contains(explained, fmt::format("{} unknowns of a single solve", solved["unknowns"].get<long>())));
  CHECK(contains(explained, "degree "));
  CHECK(contains(explained, "cost: an estimate"));
  const Ended swept =
      run(folder, "work-precision plates.toml --methods spheres,spheres-degree --json sweep.json --output sweep.png");
  CHECK(contains(swept.out, "field of 1 spheres in 1 groups"));
  const json sweep = json::parse(text_of(folder / "sweep.json"));
  double dipoles = 0, best = 1;
  for (const json& point : sweep["points"]) {
    const double error = point["errors"]["forces"].get<double>();
    if (point["method"] == "spheres") {
      CHECK(error < point["settings"]["accuracy"].get<double>());
      best = std::min(best, error);
    } else if (point["settings"]["degree"] == 1) {
      dipoles = error;
    }
  }
  CHECK(best < 1e-9);
  CHECK(dipoles > 1e-3);
  check_refused(run(folder, "work-precision plates.toml --sizes 64"), "--sizes goes with grids");
}

TEST_CASE("four electrodes and no conductor: what leaves one arrives at the others") {
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
  CHECK(std::abs(sum) < 1e-7 * largest);  // an insulated box holds no charge but what its bodies have; tolerance 1e-8
  CHECK(answer["depth"] == 1);
}

TEST_CASE("a conductor that is held stays, and the other moves") {
  const Folder folder;
  std::string scene = replaced(small_scene, "charge = 1e-10", "charge = 1e-10\n  held = true") +
                      "[effects.stokes_drag]\n[output]\nevery = 0.05\npicture = false\n[stop]\ntime = 0.1\n";
  folder.write("small.toml", scene);
  REQUIRE(run(folder, "run small.toml --quiet --set medium.viscosity=0.7").status == 0);
  const auto position =
      hdf5::get<double>(hdf5::load(folder / "small.h5"), "particles/conductors/position/value");  // 3 frames of 2
  for (const int frame : {1, 2}) {
    CHECK(position[6 * frame] == 5e-3);
    CHECK(position[6 * frame + 1] == 8e-3);
    CHECK(position[6 * frame + 4] != 8e-3);
  }
  folder.write("fast.toml", replaced(scene, "held = true", "held = true\n  velocity = [1.0, 0.0]"));
  check_refused(run(folder, "explain fast.toml --set medium.viscosity=0.7"),
                "conductor.velocity is not allowed for a conductor that is held");
}

TEST_CASE("cells fit the box, or the message says which would") {
  const Folder folder;
  folder.write("small.toml", replaced(replaced(small_scene, "[16e-3, 16e-3]", "[16e-3, 12.5e-3]"), "cells = 64", ""));
  CHECK(contains(run(folder, "explain small.toml").out, "grid                 512 x 400 cells"));
  folder.write("other.toml", replaced(replaced(small_scene, "[16e-3, 16e-3]", "[15e-3, 12.5e-3]"), "cells = 64", ""));
  CHECK(contains(run(folder, "explain other.toml").out, "grid                 516 x 430 cells"));
  check_refused(run(folder, "explain other.toml --set field.cells=64"), "field.cells = 60 or 66 would do");
}

TEST_CASE("help of a part of a scene, of a key, and in lines that fit a screen") {
  const std::string field = run("help scene field").out;
  CHECK(field.starts_with("[field]\n"));
  CHECK(contains(field, "linear_solver"));
  CHECK_FALSE(contains(field, "viscosity"));
  CHECK(run("help scene leakage").out.starts_with("[effects.leakage]"));
  const std::string key = run("help scene field.cells").out;
  CHECK(contains(key, "cells"));
  CHECK_FALSE(contains(key, "tolerance"));
  check_refused(run("help scene feild"), "the nearest is field");
  check_refused(run("help run field"), "only `help scene` has parts");
  std::istringstream lines(run("help scene").out);
  for (std::string line; std::getline(lines, line);) CHECK_MESSAGE(line.size() <= 100, line);
}

TEST_CASE("bash completes commands, options and files; man has a page") {
  const Folder folder;
  const auto completed = [&](const std::string& words) {
    return run_shell(folder, "LICHTENBERG help completion >completion.sh; bash -c 'source completion.sh; COMP_WORDS=(" +
                                 words +
                                 "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _lichtenberg; echo ${COMPREPLY[@]}'")
        .out;
  };
  CHECK(completed("lichtenberg ana") == "analyse\n");
  CHECK(completed("lichtenberg run --res") == "--resume\n");
  CHECK(completed("lichtenberg run compl") == "completion.sh\n");
  const std::string page = run("help man").out;
  CHECK(page.starts_with(".TH LICHTENBERG 1"));
  CHECK(contains(page, ".SS run SCENE [OPTIONS]"));
  CHECK(contains(page, "\\-\\-resume"));
}

#if defined(__x86_64__)
TEST_CASE("a program for another processor says so and does not end by a signal") {
  // AVX-512 ER was in Xeon Phis alone.
  const Folder folder;
  folder.write("main.cpp", "int main() {}");
  const std::string at = "-std=c++20 -I '" + source_folder() + "' -c '" + source_folder() + "/src/";
  const Ended compiled = run_shell(folder, "c++ -mavx512er " + at + "instruction_sets.cpp' && c++ " + at +
                                               "processor.cpp' && c++ main.cpp instruction_sets.o processor.o");
  REQUIRE_MESSAGE(compiled.status == 0, compiled.err);
  const Ended ended = run_shell(folder, "./a.out");
  CHECK(ended.status == 1);
  CHECK_MESSAGE(one_sentence(ended.err), ended.err);
  CHECK_MESSAGE(contains(ended.err, "compiled for processors with AVX-512 ER, which this one lacks"), ended.err);
}
#endif
