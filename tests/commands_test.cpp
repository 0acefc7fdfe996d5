// Tests of the command line: the built program, its exit status and its output.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"
#include "src/version.hpp"
#include "tests/commands.hpp"
#include "tests/source_folder.hpp"

namespace commands_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;

using nlohmann::json;

TEST_CASE("command line: wrong commands or options give one message and status 2") {
  check_refused(run(""), "lichtenberg help");
  check_refused(run("slove scene.toml"), "`solve`");
  check_refused(run("solve"), "SCENE is required");
  check_refused(run("solve a.toml b.toml"), "b.toml");
  check_refused(run("solve --jsno a.toml"), "--jsno");
  check_refused(run("help scne"), "`scene`");
}

TEST_CASE("scene file missing or with a misspelt key: one message and status 2") {
  check_refused(run("solve nowhere.toml"), "nowhere.toml");
  check_refused(run("explain nowhere.toml"), "nowhere.toml");
  const Folder folder;
  folder.write("typo.toml", small_scene + "  tolerence = 1e-6\n");
  check_refused(run(folder, "solve typo.toml"), "tolerance");
  check_refused(run(folder, "explain typo.toml"), "tolerance");
}

TEST_CASE("help: describes the program, a command and the scene file") {
  const Ended program = run("help");
  CHECK(program.status == 0);
  for (const std::string command : {"run", "solve", "explain", "plot", "film", "view", "export", "analyse", "network",
                                    "work-precision", "ensemble", "help", "--petsc"})
    CHECK(contains(program.out, command));
  CHECK(contains(run("help solve").out, "--capacitance"));
  CHECK(run("solve --help").out == run("help solve").out);
  CHECK(run("help scene").out == lichtenberg::scene_help());
}

TEST_CASE("alternative option names: in help, completion and manual page") {
  const Folder folder;
  const std::string completion = run("help completion").out, page = run("help man").out;
  for (const std::string command :
       {"run", "plot", "film", "view", "export", "network", "theory", "work-precision", "ensemble"})
    CHECK_MESSAGE(contains(run("help " + command).out, "--out,--output"), command);
  CHECK(contains(completion, "--out --output"));
  CHECK(contains(page, "\\-\\-out, \\-\\-output"));
  CHECK(contains(run("help plot").out, "--colour,--color"));
  CHECK(contains(page, "\\-\\-colour, \\-\\-color"));
  CHECK(contains(run("help export").out, "--frames,--frame"));
  CHECK_FALSE(contains(run("help plot").out, "--frames,--frame"));  // plot has its own --frame.
  for (const std::string command : {"solve", "analyse", "network", "ensemble", "theory", "work-precision"})
    CHECK_MESSAGE(contains(run("help " + command).out, "--json [=FILE]"), command);
  CHECK(contains(page, "\\-\\-json\\fR[=FILE]"));
  CHECK(contains(page, ".SS help"));
}

TEST_CASE("former option name: accepted with a warning, refused with the new one") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const Ended former = run(folder, "solve small.toml --picture=a.png");
  CHECK(former.status == 0);
  CHECK(former.err == "lichtenberg: --picture is an old name: it is called --out now\n");
  CHECK(text_of(folder / "a.png").starts_with("\x89PNG"));
  check_refused(run(folder, "solve small.toml --picture b.png --out c.png"),
                "--picture is an old name of --out: give only --out");
  check_refused(run("network x.h5 --contact-radius 1 --spot 2"), "give only --contact-radius");
  check_refused(run("run small.toml --picture a.png"), "run has no option --picture");
  const std::string texts = run("help network").out + run("help completion").out + run("help man").out;
  for (const char* shown : {"--spot ", "--spot=", "--spot\"", "\\-\\-spot\\fR"}) CHECK_FALSE(contains(texts, shown));
}

TEST_CASE("misspelt command or option: only similar words are suggested") {
  check_refused(run("analyze x.h5"), "there is no command `analyze`; did you mean `analyse`?");
  check_refused(run("help plt"), "there is no help on `plt`; did you mean `plot`?");
  check_refused(run("plot x.h5 --colur charge"), "plot has no option --colur; did you mean --colour?");
  check_refused(run("solve x.toml --capacitence"), "solve has no option --capacitence; did you mean --capacitance?");
  check_refused(run("run x.toml y.toml"),
                "run does not take `y.toml`; see `lichtenberg help run` for the allowed arguments");
  check_refused(run("help electrode"), "did you mean `help scene electrode`?");
  check_refused(run("help gravity"), "did you mean `help scene gravity`?");
  for (const std::string far : {"electrode", "simulate", "zzz"}) {
    const Ended ended = run(far);
    CHECK(ended.status == 2);
    CHECK_FALSE(contains(ended.err, "did you mean"));
    CHECK(contains(ended.err, "there is no command `" + far + "`; `lichtenberg help` lists them all"));
  }
  const Ended option = run("film x.h5 --json");
  CHECK(option.status == 2);
  CHECK(contains(option.err, "film has no option --json; see `lichtenberg help film` for the allowed arguments"));
}

TEST_CASE("--json: prints JSON instead of the table; --json=FILE writes it as well") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const json printed = json::parse(run(folder, "solve small.toml --json").out);
  CHECK(json::parse(run(folder, "solve --json small.toml").out)["energy"] == printed["energy"]);
  int number = 0;
  for (const std::string option : {"--json=1.json", "--json 2.json"}) {
    const Ended ended = run(folder, "solve small.toml " + option);
    CHECK(ended.status == 0);
    CHECK(ended.out.starts_with(run(folder, "solve small.toml").out.substr(0, 40)));
    CHECK(json::parse(text_of(folder / (std::to_string(++number) + ".json")))["energy"] == printed["energy"]);
    check_refused(run(folder, "solve small.toml " + option), "exists");
    CHECK(run(folder, "solve small.toml --overwrite " + option).status == 0);
  }
  check_refused(run(folder, "solve small.toml --json=small.toml --overwrite"), "is an input file");
  check_refused(run(folder, "solve small.toml --json="), "--json=: the value is empty");
  check_refused(run(folder, "solve small.toml --json=5.json --json"), "--json is given 2 times");
  CHECK_FALSE(std::filesystem::exists(folder / "5.json"));
  check_refused(run(folder, "solve small.toml --json=a.hdf --field a.hdf"), "a.hdf cannot be written twice");
  for (const std::string overwrite : {"", " --overwrite"})
    CHECK(run(folder, "solve small.toml --json=3.json --field a.hdf" + overwrite).status == 0);
  const Ended stability = run(folder, "theory stability --json");
  CHECK(json::parse(stability.out)["theory"] == "stability");
  CHECK(json::parse(run(folder, "theory stability --json --plot").out)["theory"] == "stability");
  CHECK(json::parse(run(folder, "theory --json stability").out)["theory"] == "stability");
  const Ended words = run(folder, "theory stability --json=any-name");
  CHECK(words.status == 0);
  CHECK_FALSE(words.out.starts_with("{"));
  CHECK(json::parse(text_of(folder / "any-name"))["theory"] == "stability");
}

TEST_CASE("option with an empty value: refused, the next word is not its value") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const std::string option :
       {"network x.h5 --terminals= --no-save", "run small.toml --out= --quiet", "solve small.toml --field= --json"})
    check_refused(run(folder, option), "=: the value is empty");
  CHECK_FALSE(std::filesystem::exists(folder / "--quiet"));
}

TEST_CASE("--overwrite: refused for a command that writes no file") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const std::string command : {"solve small.toml", "solve small.toml --json", "theory stability"})
    check_refused(run(folder, command + " --overwrite"), "--overwrite is not allowed where no file is written");
  CHECK(run(folder, "solve small.toml --overwrite --json=a.json").status == 0);
}

TEST_CASE("explain --from: a dense population needs no random positions") {
  const Folder folder;
  // Random positions are not found above an area fraction of about 0.55.
  const std::string scene = R"(
  [domain]
  size = [6.0, 6.0]
  [[population]]
  count = 4
  radius = 1.4
  [effects.stokes_drag]
  [medium]
  viscosity = 1.0
  [output]
  every = 0.1
  picture = false
  [stop]
  time = 0.1
)";
  std::string given = scene.substr(0, scene.find("[[population]]"));
  for (const std::string at : {"1.5, 1.5", "4.5, 1.5", "1.5, 4.5", "4.5, 4.5"})
    given += "[[conductor]]\nposition = [" + at + "]\nradius = 1.4\n";
  folder.write("given.toml", given + scene.substr(scene.find("[effects.stokes_drag]")));
  folder.write("dense.toml", scene);
  REQUIRE(run(folder, "run given.toml --quiet").status == 0);
  check_refused(run(folder, "explain dense.toml"), "population.count = 4 is impossible");
  const Ended ended = run(folder, "explain dense.toml --from given.h5 --frame 0");
  INFO(ended.err);
  CHECK(ended.status == 0);
  CHECK(contains(ended.out, "conductors           4"));
  check_refused(run(folder, "explain dense.toml --frame 0"), "--frame needs --from");
}

TEST_CASE("--version: prints the program's version and commit") {
  const Ended result = run("--version");
  CHECK(result.status == 0);
  CHECK(result.out.starts_with(fmt::format("lichtenberg {} (", lichtenberg_version().number)));
}

TEST_CASE("solve, explain and help: a full standard output gives status 1") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const std::string arguments : {"solve small.toml --json", "explain small.toml", "help scene"}) {
    const Ended result = run(folder, arguments + " >/dev/full");
    CHECK(result.status == 1);
    CHECK(contains(result.err, "No space left on device"));  // Either {fmt} or the program reports the failure.
  }
}

TEST_CASE("run: a conductor that leaves the domain ends it with status 1") {
  const Folder folder;
  // 1 m/s through 7 mm of fluid without drag or contact.
  folder.write(
      "lost.toml",
      "[domain]\nsize = [1e-2, 1e-2]\n[medium]\nrelative_permittivity = 2\n[[conductor]]\nposition = [3e-3, 5e-3]\n"
      "radius = 1e-3\nvelocity = [1, 0]\n[effects.floating_conductors]\n[field]\ncells = 32\n[stop]\ntime = 0.1\n");
  const Ended result = run(folder, "run lost.toml --quiet");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "conductor 0 has left the domain"));
  CHECK(contains(result.err, "[effects.wall_contact]"));
}

TEST_CASE("explain: lists effects and unknowns and does not start PETSc") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  // If PETSc started, it would end with a list of the unused options.
  const Ended result = run(folder, "explain small.toml --petsc -options_left -nobodys_option");
  REQUIRE(result.status == 0);
  CHECK_FALSE(contains(result.out + result.err, "nobodys_option"));
  const std::size_t absent = result.out.find("effects not computed");
  REQUIRE(absent != std::string::npos);
  for (const auto& effect : lichtenberg::effects::summarize_effects({}))
    CHECK((result.out.find(effect.name) < absent) == (effect.name == "floating_conductors"));
  const json answer = json::parse(run(folder, "solve small.toml --json").out);
  CHECK(contains(result.out, fmt::format(" {}:", answer["unknowns"].get<long>())));
}

TEST_CASE("explain: a grid of 2^30 cells gives status 0 and its unknowns") {
  const Folder folder;
  // 2^30 cells with about 100 bytes each.
  folder.write(
      "huge.toml",
      "[domain]\nsize = [1e-2, 1e-2]\n[medium]\nrelative_permittivity = 2\n[[conductor]]\nposition = [5e-3, 5e-3]\n"
      "radius = 1e-7\n[effects.floating_conductors]\n[field]\ncells = 32768\n");
  const Ended result = run(folder, "explain huge.toml");
  CHECK(result.status == 0);
  CHECK(contains(result.out, "at most 1073741824"));
  CHECK(contains(result.out, "0.328 cells, less than one"));  // 1e-7 m / (1e-2 m / 32768)
}

TEST_CASE("explain: a neutral scene needs no charges or field and has no unknowns") {
  const Folder folder;
  folder.write("neutral.toml",
               "[domain]\nsize = [1e-2, 1e-2]\n[[conductor]]\nposition = [5e-3, 5e-3]\nradius = 1e-3\n");
  const Ended result = run(folder, "explain neutral.toml");
  CHECK(result.status == 0);
  CHECK(contains(result.out, "charges, field, neighbour list"));
  CHECK_FALSE(contains(result.out, "unknowns"));
}

namespace {

/// Number before `unit` in the line that begins with `label`.
double number_before(const std::string& text, const std::string& label, const std::string& unit) {
  std::istringstream lines(text.substr(text.find(label)));
  std::string word, before;
  while (lines >> word && word != unit) before = word;
  return std::stod(before);
}

}  // namespace

TEST_CASE("explain: predicts a packing's iterations within a factor of three") {
  const Folder folder;
  for (const double side : {19.78e-3, 20.58e-3}) {  // 400 disks have area fractions of 0.92 and 0.85.
    folder.write("packing.toml",
                 fmt::format("[domain]\nsize = [{0}, {0}]\n[[population]]\ncount = 400\nradius = [0.4e-3, 0.66e-3]\n"
                             "overlapping = true\n[effects.soft_repulsion]\n[output]\npicture = false\n",
                             side));
    const Ended explained = run(folder, "explain packing.toml");
    REQUIRE(explained.status == 0);
    const double predicted = number_before(explained.out, "  a run", "iterations,");
    const Ended ran = run(folder, "run packing.toml --out packing.h5 --overwrite");
    REQUIRE(ran.status == 0);
    const double found = number_before(ran.out, "at rest after", "iterations");
    CHECK(predicted < 3 * found);
    CHECK(found < 3 * predicted);
  }
  folder.write("slow.toml",
               "[domain]\nsize = [1e-2, 1e-2]\n[[population]]\ncount = 20\nradius = 1e-3\noverlapping = true\n"
               "[effects.soft_repulsion]\n[minimize]\nmethod = \"gradient-descent\"\n");
  CHECK(contains(run(folder, "explain slow.toml").out, "no estimate: gradient descent"));
}

TEST_CASE("explain: measures the cost of a shuttle's run, adds that of the picture") {
  const Folder folder;
  const std::string scene = source_folder() + "/scenes/shuttle.toml";
  const Ended result = run(folder, "explain " + scene);
  REQUIRE(result.status == 0);
  CHECK(contains(result.out, "measured here"));
  CHECK(contains(result.out, "its picture"));
  CHECK_FALSE(contains(run(folder, "explain " + scene + " --set output.picture=false").out, "its picture"));
  // 0.1 % of the time is run to its end.
  CHECK(contains(run(folder, "explain " + scene + " --set stop.time=1e-3").out,
                 "measured here up to its end at 0.001 s"));
}

TEST_CASE("explain: measures the cost of a run without drag and one without field") {
  const Folder folder;
  folder.write("charged.toml", small_scene + "[stop]\ntime = 1e-3\nstationary = false\n");
  folder.write("falling.toml",
               "[domain]\nsize = [0.01, 0.01]\n[medium]\nviscosity = 1.8e-5\n[[conductor]]\nposition = [5e-3, 9e-3]\n"
               "radius = 1e-5\n[effects.gravity]\n[effects.stokes_drag]\n[stop]\ntime = 1e-3\nstationary = false\n");
  for (const std::string scene : {"charged.toml", "falling.toml"}) {
    CAPTURE(scene);
    const Ended result = run(folder, "explain " + scene);
    REQUIRE_MESSAGE(result.status == 0, result.err);
    CHECK(contains(result.out, "measured here up to its end at 0.001 s"));
    CHECK_FALSE(contains(result.out, "no estimate"));
  }
}

TEST_CASE("plot: a missing file or one that is no result is refused") {
  const Folder folder;
  const Ended missing = run(folder, "plot nowhere.h5");
  CHECK(missing.status == 2);
  CHECK(contains(missing.err, "nowhere.h5"));
  folder.write("text.h5", "no HDF5");
  CHECK(run(folder, "plot text.h5").status == 2);
  CHECK_FALSE(std::filesystem::exists(folder / "text.png"));
}

TEST_CASE("work-precision: prints tables, writes picture and JSON, replaces no file") {
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

TEST_CASE("work-precision: wrong methods, sizes and output names are refused") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  check_refused(run(folder, "work-precision small.toml --methods sor"), "sor");
  check_refused(run(folder, "work-precision small.toml --sizes 4"), "--sizes 4");
  check_refused(run(folder, "work-precision small.toml --time --sizes 64"), "--sizes");
  check_refused(run(folder, "work-precision small.toml --seconds 0"), "--seconds");
  check_refused(run(folder, "work-precision small.toml --output small.gif"), "small.gif");
  check_refused(run(folder, "work-precision small.toml --output a.png --json=./a.png"), "--json ./a.png");
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path), {}) == 3);  // The scene, out and err.
}

TEST_CASE("--set KEY=VALUE: changes any key of a scene; wrong keys are refused") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  const Ended explained = run(folder, "explain small.toml --set field.cells=32 --set 'medium.depth = 2e-3'");
  CHECK(explained.status == 0);
  CHECK(contains(explained.out, "32 x 32 cells"));
  CHECK(contains(run(folder, "explain small.toml --set field.method=multipole").out, "multipole"));
  const json plain = json::parse(run(folder, "solve small.toml --json").out);
  const json deep = json::parse(run(folder, "solve small.toml --json --set medium.depth=4e-3").out);
  // Equal charge and twice the depth.
  CHECK(deep["energy"].get<double>() == near(0.5 * plain["energy"].get<double>(), 1e-9));
  check_refused(run(folder, "solve small.toml --set field.cell=32"), "the nearest known key is field.cells");
  check_refused(run(folder, "solve small.toml --set field.cells=-1"), "small.toml: field.cells = -1 is not allowed");
  check_refused(run(folder, "solve small.toml --set conductor[1].radius=0"), "conductor.radius = 0 is not allowed");
  check_refused(run(folder, "solve small.toml --set field.accuracy=1e-3"), "field.cells is chosen for field.accuracy");
  check_refused(run(folder, "solve small.toml --set field.accuracy=1e-3 --set field.cells=32"),
                "small.toml: field.cells is chosen for field.accuracy");
  check_refused(run(folder, "solve small.toml --set field.cells"), "it must be KEY=VALUE");
}

TEST_CASE("field.cells: defaults fit the domain; an error suggests two that fit") {
  const Folder folder;
  folder.write("small.toml", replaced(replaced(small_scene, "[16e-3, 16e-3]", "[16e-3, 12.5e-3]"), "cells = 64", ""));
  CHECK(contains(run(folder, "explain small.toml").out, "grid                 512 x 400 cells"));
  folder.write("other.toml", replaced(replaced(small_scene, "[16e-3, 16e-3]", "[15e-3, 12.5e-3]"), "cells = 64", ""));
  CHECK(contains(run(folder, "explain other.toml").out, "grid                 516 x 430 cells"));
  check_refused(run(folder, "explain other.toml --set field.cells=64"), "field.cells = 60 or 66 would do");
}

TEST_CASE("help scene: prints tables or keys in lines of at most 100 columns") {
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

TEST_CASE("bash completion: completes commands, options and files; help man works") {
  const Folder folder;
  const auto completed = [&](const std::string& words) {
    return run_shell(folder, "LICHTENBERG help completion >completion.sh; bash -c 'source completion.sh; COMP_WORDS=(" +
                                 words +
                                 "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _lichtenberg; echo ${COMPREPLY[@]}'")
        .out;
  };
  CHECK(completed("lichtenberg ana") == "analyse\n");
  CHECK(completed("lichtenberg --v") == "--version\n");
  CHECK(completed("lichtenberg run --res") == "--resume\n");
  CHECK(completed("lichtenberg solve --he") == "--help\n");
  for (const char* name : {"a.toml", "a.h5", "a.txt", "b file.toml"}) folder.write(name, "");
  std::filesystem::create_directory(folder / "a");
  CHECK(completed("lichtenberg run a") == "a a.toml\n");
  CHECK(completed("lichtenberg run b") == "b file.toml\n");
  CHECK(completed("lichtenberg run --overwrite a") == "a a.toml\n");
  CHECK(completed("lichtenberg run --from a") == "a a.h5\n");
  CHECK(completed("lichtenberg run --from = a") == "a a.h5\n");
  CHECK(completed("lichtenberg plot --series a") == "a a.h5\n");
  CHECK(completed("lichtenberg theory haff --scene a") == "a a.toml\n");
  CHECK(completed("lichtenberg solve --json = a.t") == "a.toml a.txt\n");
  CHECK(completed("lichtenberg solve --json a") == "a a.toml\n");
  CHECK(completed("lichtenberg plot --frame a") == "\n");
  CHECK(completed("lichtenberg run --device = c") == "cpu cuda\n");
  CHECK(completed("lichtenberg theory haff h") == "\n");
  CHECK(completed("lichtenberg help scene visco") == "viscoelastic_contact\n");
  CHECK(completed("lichtenberg run compl") == "completion.sh\n");
  CHECK(completed("lichtenberg plot --col") == "--colour --color\n");
  CHECK(completed("lichtenberg run --device \"\"") == "cpu cuda\n");
  CHECK(completed("lichtenberg plot --colour pot") == "potential\n");
  CHECK(completed("lichtenberg theory haf") == "haff\n");
  CHECK(completed("lichtenberg help sc") == "scene\n");
  CHECK(completed("lichtenberg hel") == "help\n");
  const std::string page = run("help man").out;
  CHECK(page.starts_with(".TH LICHTENBERG 1"));
  CHECK(contains(page, ".SS run SCENE [OPTIONS]"));
  CHECK(contains(page, "\\-\\-resume"));
  for (const std::string& text : {page, run("help").out, run("help run").out}) {
    CHECK(contains(text, "Exit status: 0 for success, 1 for work that failed, 2 for input that cannot be used"));
    CHECK(contains(text, "130 for Ctrl"));
  }
}

#if defined(__x86_64__)
TEST_CASE("program built for another processor: ends with a message and status 1") {
  // Only Xeon Phi processors have AVX-512 ER.
  const Folder folder;
  folder.write("main.cpp", "int main() {}");
  const std::string at = "-std=c++20 -I '" + source_folder() + "' -c '" + source_folder() + "/src/";
  const Ended compiled = run_shell(folder, "c++ -mavx512er " + at + "instruction_sets.cpp' && c++ " + at +
                                               "processor.cpp' && c++ main.cpp instruction_sets.o processor.o");
  REQUIRE_MESSAGE(compiled.status == 0, compiled.err);
  const Ended ended = run_shell(folder, "./a.out");
  CHECK(ended.status == 1);
  CHECK_MESSAGE(is_one_line(ended.err), ended.err);
  // A processor without AVX-512 lacks this first.
  CHECK_MESSAGE(contains(ended.err, "compiled for processors with AVX-512"), ended.err);
  CHECK_MESSAGE(contains(ended.err, ", which this one lacks"), ended.err);
}
#endif

}  // namespace commands_test
