// Tests of runs from the command line: starts from a frame, JSON, stored columns.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "src/record/hdf5.hpp"
#include "tests/commands.hpp"

namespace commands_run_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;

using nlohmann::json;

namespace {

/// Returns the small scene with drag, frames each 0.01 s and an end (s).
std::string moving_scene(const std::string& end) {
  return small_scene + "[effects.stokes_drag]\n[output]\nevery = 0.01\npicture = false\n[stop]\ntime = " + end + "\n";
}

/// Returns a periodic gas of 8 grains with an end (t0).
std::string small_gas(const std::string& end) {
  std::string scene = "[units]\n[domain]\nsize = [8, 8, 8]\n";
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"})
    scene += std::string(side) + " = \"periodic\"\n";
  return scene +
         "[[population]]\ncount = 8\ntemperature = 1\n[effects.viscoelastic_contact]\n"
         "[output]\npicture = false\n[stop]\ntime = " +
         end + "\n";
}

}  // namespace

TEST_CASE("solve --from: solves the field at a frame of a run") {
  const Folder folder;
  folder.write("small.toml", moving_scene("0.02"));
  const std::string drag = " --set medium.viscosity=0.7";
  REQUIRE(run(folder, "run small.toml --quiet" + drag).status == 0);
  const auto position = hdf5::get<double>(hdf5::load(folder / "small.h5"), "particles/conductors/position/value");
  const json last = json::parse(run(folder, "solve small.toml --json --from small.h5" + drag).out);
  const json first = json::parse(run(folder, "solve small.toml --json --from small.h5 --frame 0" + drag).out);
  CHECK(first["energy"] == json::parse(run(folder, "solve small.toml --json" + drag).out)["energy"]);
  CHECK(last["energy"] != first["energy"]);
  for (const int axis : {0, 1}) CHECK(last["conductors"][1]["position"][axis] == position[position.size() - 3 + axis]);
  check_refused(run(folder, "solve small.toml --frame 0"), "--frame needs --from");
  check_refused(run(folder, "solve small.toml --from small.h5 --overwrite --json=small.h5" + drag), "is an input file");
}

TEST_CASE("side in a circuit: explain and run take it, solve refuses it") {
  const Folder folder;
  const auto write = [&](const std::string& third_size, const std::string& third, const std::string& field) {
    folder.write("side.toml", "domain = { size = [0.04, 0.02" + third_size +
                                  "], left = { potential = 9, series_resistance = 1e9 }, right = { potential = 0 } }\n"
                                  "medium = { relative_permittivity = 2 }\n" +
                                  field + "[effects.floating_conductors]\n[[conductor]]\nposition = [0.01, 0.01" +
                                  third + "]\nradius = 2e-3\n[output]\npicture = false\n[stop]\ntime = 1e-3\n");
  };
  for (const bool in_space : {false, true}) {
    in_space ? write(", 0.02", ", 0.01", "") : write("", "", "field = { cells = 64 }\n");
    const Ended explained = run(folder, "explain side.toml");
    CHECK(explained.status == 0);
    CHECK(contains(explained.out, "9 V behind 1e+09 ohm"));
    CHECK(run(folder, "run side.toml --quiet --overwrite").status == 0);
    check_refused(run(folder, "solve side.toml"), "a side of the domain is in a circuit");
  }
}

TEST_CASE("run --json, explain --json: print JSON alone, replace no FILE") {
  const Folder folder;
  folder.write("small.toml", small_scene + "[effects.stokes_drag]\n[output]\nevery = 0.01\n[stop]\ntime = 0.01\n");
  const std::string scene = "small.toml --set medium.viscosity=0.7";
  const json explained = json::parse(run(folder, "explain --json " + scene).out);
  CHECK(explained["effects"] == json({"floating_conductors", "stokes_drag"}));
  CHECK(explained["quantities"]["particles"]["value"] == 2);
  CHECK(explained["quantities"]["cells"]["value"] == 64 * 64);
  CHECK(explained["quantities"]["memory"]["unit"] == "B");
  const Ended written = run(folder, "explain --json=explained.json " + scene);
  CHECK(contains(written.out, "effects in the run"));
  CHECK(json::parse(text_of(folder / "explained.json"))["effects"] == explained["effects"]);
  check_refused(run(folder, "explain --json=explained.json " + scene), "explained.json exists");
  check_refused(run(folder, "explain --overwrite " + scene), "--overwrite is not allowed where no file is written");
  check_refused(run(folder, "run --json=explained.json " + scene), "explained.json exists");
  check_refused(run(folder, "run --json=none/a.json " + scene), "there is no folder");
  check_refused(run(folder, "run --json=a.h5 --out a.h5 " + scene), "a.h5 cannot be written twice");
  CHECK_FALSE(std::filesystem::exists(folder / "small.h5"));
  const json ran = json::parse(run(folder, "run --json " + scene).out);
  CHECK(ran["file"] == "small.h5");
  CHECK(ran["quantities"]["time"] == json({{"value", 0.01}, {"unit", "s"}}));
  CHECK(ran["seconds"].contains("picture"));
  CHECK(run(folder, "run --json --overwrite " + scene + " >/dev/full").status == 1);
  const Ended both = run(folder, "run --json=ran.json --overwrite " + scene);
  CHECK(contains(both.out, "small.h5 holds the run"));
  CHECK(json::parse(text_of(folder / "ran.json"))["quantities"] == ran["quantities"]);
}

TEST_CASE("run --from: starts at a frame of another run; conflicts are refused") {
  const Folder folder;
  folder.write("small.toml", moving_scene("0.05"));
  const std::string drag = " --quiet --set medium.viscosity=0.7";
  REQUIRE(run(folder, "run small.toml --out first.h5" + drag).status == 0);
  const Ended second = run(folder, "run small.toml --out second.h5 --from first.h5 --frame 3" + drag);
  REQUIRE_MESSAGE(second.status == 0, second.err);
  const auto rows = [&](const std::string& file, const std::string& column) {
    return hdf5::get<double>(hdf5::load(folder / file), "particles/conductors/" + column + "/value");
  };
  for (const std::string column : {"position", "charge", "velocity"}) {
    const std::vector<double> first = rows("first.h5", column), then = rows("second.h5", column);
    const std::size_t row = first.size() / 6;  // Frames.
    for (std::size_t k = 0; k < row; ++k) CHECK(then[k] == first[3 * row + k]);
  }
  check_refused(run(folder, "run small.toml --out third.h5 --from first.h5 --frame 6" + drag), "frames 0 to 5");
  check_refused(run(folder, "run small.toml --out third.h5 --frame 1" + drag), "--from");
  check_refused(run(folder, "run small.toml --out third.h5 --from first.h5 --set conductor[0].radius=0.9e-3" + drag),
                "body 0 has a radius of 0.001");
  check_refused(run(folder, "run small.toml --out second.h5 --resume" + drag), "with the same --from and --frame");
  CHECK(run(folder, "run small.toml --out second.h5 --resume --from first.h5 --frame 3" + drag).status == 0);
}

TEST_CASE("analyse: a current that contacts leave undefined is no number") {
  const Folder folder;
  folder.write("small.toml", moving_scene("0.02") +
                                 "[effects.contact_discharge]\n[[electrode]]\nname = \"tip\"\nshape = \"disk\"\n"
                                 "centre = [8e-3, 13e-3]\nradius = 1e-3\n[[circuit]]\nelectrodes = [\"tip\"]\n"
                                 "potential = 100\nresistance = 1e10\n");
  const Ended ended = run(folder, "run small.toml --quiet --set medium.viscosity=1");
  REQUIRE_MESSAGE(ended.status == 0, ended.err);
  const std::string found = run(folder, "analyse small.h5").out;
  CHECK_MESSAGE(contains(found, "recorded       current not defined, "), found);
  CHECK_MESSAGE(!contains(found, "nan"), found);
}

TEST_CASE("box in space: explain prints its three lengths, run stores them") {
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

TEST_CASE("fixed conductor: stays in place while the other one moves") {
  const Folder folder;
  std::string scene = replaced(small_scene, "charge = 1e-10", "charge = 1e-10\n  fixed = true") +
                      "[effects.stokes_drag]\n[output]\nevery = 0.05\npicture = false\n[stop]\ntime = 0.1\n";
  folder.write("small.toml", scene);
  REQUIRE(run(folder, "run small.toml --quiet --set medium.viscosity=0.7").status == 0);
  const auto position =
      // 3 frames of 2 conductors.
      hdf5::get<double>(hdf5::load(folder / "small.h5"), "particles/conductors/position/value");
  for (const int frame : {1, 2}) {
    CHECK(position[6 * frame] == 5e-3);
    CHECK(position[6 * frame + 1] == 8e-3);
    CHECK(position[6 * frame + 4] != 8e-3);
  }
  folder.write("fast.toml", replaced(scene, "fixed = true", "fixed = true\n  velocity = [1.0, 0.0]"));
  check_refused(run(folder, "explain fast.toml --set medium.viscosity=0.7"),
                "conductor.velocity is not allowed with conductor.fixed");
}

TEST_CASE("--device: values that are no device or list of devices are refused") {
  const Folder folder;  // The scene does not exist: it is read later.
  const std::string allowed = "is not allowed: it must be cpu, cuda, or for several devices cuda:0,1 or cuda:all";
  for (const std::string value :
       {"gpu", "cpu:0", "cuda:", "cuda:x", "cuda:-1", "cuda:0,", "cuda:,1", "\"cuda:0 1\"", "cuda:0,all", "cuda0"})
    check_refused(run(folder, "run none.toml --device " + value), allowed);
  for (const std::string command : {"explain", "solve", "ensemble"})
    check_refused(run(folder, command + " none.toml --device gpu"), allowed);
  check_refused(run(folder, "run none.toml --device cuda:1,0,1"),
                "--device cuda:1,0,1 is not allowed: it has the device 1 twice");
}

TEST_CASE("--device: lists of devices that a field cannot use are refused") {
  const Folder folder;
  folder.write("small.toml", small_scene);
  for (const auto& [command, value] :
       {std::pair<std::string, std::string>{"run", "cuda:0"}, {"explain", "cuda:0"}, {"ensemble", "cuda:0"}})
    check_refused(
        run(folder, command + " small.toml --device " + value),
        "--device " + value + " is for grains only: a field needs --device cuda, without numbers, or several devices");
  check_refused(run(folder, "solve small.toml --device cuda:0,1 --set field.linear_solver=assembled"),
                "--device cuda:0,1 needs field.linear_solver = \"multigrid\"");
  check_refused(run(folder, "ensemble small.toml --device cuda:all"),
                "an ensemble of fields needs --device cuda, without a list of devices");
}

TEST_CASE("--device cuda:0,1: refused for a gas without gain, also by --resume") {
  const Folder folder;
  folder.write("gas.toml", small_gas("0.1"));
  const std::string slower =
      "8 grains faster than one does (they gain from 300000 grains on): one device is needed, as in --device cuda:0";
  for (const std::string command : {"run", "explain"})
    check_refused(run(folder, command + " gas.toml --device cuda:0,1"), slower);
  check_refused(run(folder, "solve gas.toml --device cuda:1"), "--device cuda is for scenes of conductors");
  REQUIRE(run(folder, "run gas.toml --quiet").status == 0);
  const auto positions = [&] {
    return hdf5::get<double>(hdf5::load(folder / "gas.h5"), "particles/conductors/position/value");
  };
  const auto before = positions();
  check_refused(run(folder, "run gas.toml --resume --device cuda:0,1"), slower);
  CHECK(positions() == before);
}

TEST_CASE("ensemble --device cuda:1,3: members have one device each") {
  const Folder folder;
  folder.write("gas.toml", small_gas("0.1"));
  const auto devices_of = [&](const std::string& device) {
    const std::string answers = run(folder, "ensemble-members gas.toml --out many" + device).out;
    return json::parse(answers.substr(0, answers.find('\n')))["devices"];
  };
  CHECK(devices_of(" --device cuda:1,3") == json{"cuda:1", "cuda:3"});
  CHECK(devices_of(" --device cuda").empty());
  CHECK(devices_of("").empty());
}

}  // namespace commands_run_test
