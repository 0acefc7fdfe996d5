// Tests of the command ensemble with the built program on short scenes of a few conductors.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "src/record/atomic_file.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/seal.hpp"
#include "tests/ensembles.hpp"

namespace ensemble_test {

using namespace lichtenberg;
using namespace lichtenberg::ensembles;
namespace fs = std::filesystem;
using nlohmann::json;

TEST_CASE("ensemble: runs all combinations, each into a file of its own") {
  const ScenesFolder folder;
  const Ended result = ensemble(folder, "neutral.toml --vary medium.viscosity=0.5,1.0 --conductors 1,2 --seeds 2");
  INFO(result.err);
  CHECK(result.status == 0);
  const json found = summary(folder, "neutral-ensemble");
  REQUIRE(found["members"].size() == 8);
  CHECK(found["points"].size() == 4);
  for (const json& point : found["points"]) CHECK(point["runs"] == 2);
  CHECK(found["members"][7]["name"] == "count-2_viscosity-1_seed-4");
  CHECK(found["members"][7]["settings"] == json({{"population.count", 2}, {"medium.viscosity", 1}, {"seed", 4}}));
  CHECK(found["members"][7]["quantities"]["conductors"] == 3);
  for (const json& member : found["members"]) {
    CHECK(member["state"] == "finished");
    const fs::path file = folder / "neutral-ensemble" / member["name"].get<std::string>();
    CHECK(last_time(file.string() + ".h5") == doctest::Approx(0.1));
    CHECK(fs::exists(file.string() + ".toml"));
    CHECK_FALSE(fs::exists(file.string() + ".png"));
  }
}

TEST_CASE("ensemble: means, deviations and slopes equal those of the members") {
  const ScenesFolder folder;
  const Ended result = ensemble(folder, "charged.toml --conductors 4,7 --seeds 3 --json");
  INFO(result.err);
  REQUIRE(result.status == 0);
  const json found = json::parse(result.out);
  CHECK(found == summary(folder, "charged-ensemble"));
  const std::string version = run_program(folder, "--version").out;
  for (const std::string part : {"version", "commit"}) CHECK(contains(version, found[part].get<std::string>()));
  double sum = 0, squares = 0, endpoints = 0, conductors = 0;
  for (const json& member : found["members"]) {
    const json& quantities = member["quantities"];
    endpoints += quantities["endpoints"].get<double>();
    conductors += quantities["conductors"].get<double>();
    if (member["settings"]["population.count"] != 7) continue;
    sum += quantities["field_solves"].get<double>();
    squares += std::pow(quantities["field_solves"].get<double>(), 2);
  }
  CHECK(conductors == 3 * (4 + 7));
  CHECK(endpoints > 0);
  REQUIRE(found["points"].size() == 2);
  const json& solves = found["points"][1]["quantities"]["field_solves"];
  const double mean = sum / 3, deviation = std::sqrt((squares - 3 * mean * mean) / 2);
  CHECK(solves["sample"] == 3);
  CHECK(solves["value"].get<double>() == doctest::Approx(mean));
  CHECK(solves["deviation"].get<double>() == doctest::Approx(deviation));
  // Student's t for 2 degrees of freedom.
  CHECK(solves["half_width"].get<double>() == doctest::Approx(4.303 * deviation / std::sqrt(3)).epsilon(2e-4));
  REQUIRE(found["proportions"].size() == 5);  // Endpoints, branch points and three Strahler numbers.
  CHECK(found["proportions"][0]["quantity"] == "endpoints");
  CHECK(found["proportions"][0]["slope"]["value"].get<double>() == doctest::Approx(endpoints / conductors));
}

TEST_CASE("ensemble: degree fractions in tree, without ground, without hysteresis") {
  // 0 touches the ground; 1 and 2 touch 0 and each other; 3 touches 2. Conductor 3 starts within the contact gap of 0.6
  // mm at 32.6 mm/s. Drag stops it in the hysteresis band after 0.03 mm (tau = 2 R^2 density / 9 viscosity = 0.92 ms).
  // The degrees are 3 (with the ground), 2, 3 and 1; the tree has the edges 0-1, 0-2 and 2-3.
  const ScenesFolder folder;
  const auto conductor = [](const std::string& position) {
    return "[[conductor]]\nradius = 0.6e-3\nposition = " + position + "\n";
  };
  std::string loop = replaced(charged_scene, "[[population]]\ncount = 6\nradius = 0.6e-3\nmin_gap = 0.1e-3\n", "");
  loop = replaced(loop, "time = 0.2", "time = 0.01") + "[material]\ndensity = 8050.0\n";
  loop += conductor("[4e-3, 1.7e-3]") + conductor("[3.25e-3, 3.0e-3]") + conductor("[4.75e-3, 3.0e-3]");
  loop += conductor("[6.3002e-3, 3.895e-3]") + "velocity = [28.23e-3, 16.3e-3]\n";  // 1.79 mm from 2.
  folder.write("charged.toml", loop);
  const Ended result = ensemble(folder, "charged.toml --json");
  INFO(result.err);
  REQUIRE(result.status == 0);
  const json parsed = json::parse(result.out);
  const json& quantities = parsed["members"][0]["quantities"];
  REQUIRE(quantities["connected"] == 4);
  const auto check = [&](const std::string& reading, double endpoints, double branch_points) {
    CAPTURE(reading);
    CHECK(quantities["endpoint_fraction" + reading] == endpoints);
    CHECK(quantities["branch_fraction" + reading] == branch_points);
  };
  check("", 0.25, 0.5);
  check("_in_tree", 0.5, 0.25);             // 3, 1, 2, 1
  check("_without_ground", 0.25, 0.25);     // 2, 2, 3, 1
  check("_without_hysteresis", 0.0, 0.25);  // 3, 2, 2, 0
  CHECK(quantities["degree_fraction_2"] == 0.25);
  CHECK(quantities["strahler_fraction_1"] == 0.75);
}

TEST_CASE("ensemble: prints a table of means with confidence intervals") {
  const ScenesFolder folder;
  const Ended result = ensemble(folder, "charged.toml --conductors 4,5 --seeds 2");
  CHECK(result.status == 0);
  for (const std::string part : {"4 of 4 runs", "population.count", "endpoints f1", "branch points B", "±", "D 7.11"})
    CHECK(contains(result.out, part));
}

TEST_CASE("ensemble: a member's scene file alone reproduces its run") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "charged.toml --vary population.count=5").status == 0);
  REQUIRE(run_program(folder, "run charged-ensemble/count-5.toml --out alone.h5 --quiet").status == 0);
  namespace hdf5 = lichtenberg::hdf5;
  const hdf5::Handle alone = hdf5::load((folder / "alone.h5").string());
  const hdf5::Handle member = hdf5::load((folder / "charged-ensemble" / "count-5.h5").string());
  const std::string positions = "particles/conductors/position/value";
  CHECK(hdf5::get<double>(alone, positions) == hdf5::get<double>(member, positions));
}

TEST_CASE("ensemble: completed members are not run again") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "neutral.toml --seeds 2").status == 0);
  const fs::path out = folder / "neutral-ensemble";
  const std::string before = text_of(out / "seed-3.h5");
  // Each run's scene is written before the run starts.
  const auto scene_written = fs::last_write_time(out / "seed-3.toml");
  REQUIRE(ensemble(folder, "neutral.toml --seeds 3").status == 0);  // One more member.
  CHECK(text_of(out / "seed-3.h5") == before);
  CHECK(fs::last_write_time(out / "seed-3.toml") == scene_written);
  CHECK(summary(folder, "neutral-ensemble")["members"].size() == 3);
}

TEST_CASE("ensemble --json=FILE: replaces the file only if it has written it") {
  const ScenesFolder folder;
  const std::string arguments = "neutral.toml --seeds 2 --json=" + (folder / "table.json").string();
  REQUIRE(ensemble(folder, arguments).status == 0);
  CHECK(ensemble(folder, arguments).status == 0);
  std::ofstream(folder / "table.json") << "{}";
  const Ended refused = ensemble(folder, arguments);
  CHECK(refused.status == 2);
  CHECK(contains(refused.err, "table.json exists"));
  CHECK_FALSE(contains(refused.err, "--overwrite"));  // ensemble does not have this option.
}

TEST_CASE("ensemble: incomplete members are resumed up to the new stop time") {
  const ScenesFolder folder;
  const std::string shorter = replaced(charged_scene, "time = 0.2", "time = 0.08");  // The 8th frame has a checkpoint.
  folder.write("charged.toml", shorter);
  REQUIRE(ensemble(folder, "charged.toml --seeds 2").status == 0);
  folder.write("charged.toml", charged_scene);
  REQUIRE(ensemble(folder, "charged.toml --seeds 2").status == 0);
  for (const std::string name : {"seed-3.h5", "seed-4.h5"}) {
    CHECK(last_time(folder / "charged-ensemble" / name) == doctest::Approx(0.2));
    CHECK(sessions(folder / "charged-ensemble" / name) == 2);
  }
}

TEST_CASE("ensemble: packings stopped at max_iterations continue with more of them") {
  const ScenesFolder folder;
  const std::string packing =
      "[domain]\nsize = [6.4, 6.4]\n[effects.soft_repulsion]\n[output]\npicture = false\n"
      "[[population]]\ncount = 50\nradius = [0.4, 0.6]\noverlapping = true\n[minimize]\n";
  const auto at_rest = [&] { return summary(folder, "packing-ensemble")["members"][0]["quantities"]["at_rest"]; };
  folder.write("packing.toml", packing + "max_iterations = 20\n");
  REQUIRE(ensemble(folder, "packing.toml").status == 0);
  CHECK(at_rest() == 0);
  folder.write("packing.toml", packing);
  REQUIRE(ensemble(folder, "packing.toml").status == 0);
  CHECK(at_rest() == 1);
}

TEST_CASE("ensemble: a member past the new stop time fails and its file stays") {
  const ScenesFolder folder;
  const std::string stop = "time = 0.08";  // The 8th frame has a checkpoint.
  folder.write("charged.toml", replaced(charged_scene, "time = 0.2", stop));
  REQUIRE(ensemble(folder, "charged.toml").status == 0);
  const fs::path file = folder / "charged-ensemble" / "charged.h5";
  const std::string before = text_of(file);
  const auto check_past = [&] {
    const Ended result = ensemble(folder, "charged.toml");
    INFO(result.err);
    CHECK(result.status == 1);
    CHECK(contains(result.err, "charged.h5 is already past the end that [stop] now sets: move it away"));
    CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>{"failed"});
  };
  folder.write("charged.toml", replaced(charged_scene, "time = 0.2", "time = 0.05"));
  check_past();
  CHECK(text_of(file) == before);

  // The file is that of a run interrupted at its 8th frame before a later end. Nothing is left to run.
  namespace hdf5 = lichtenberg::hdf5;
  const auto interrupted = std::make_shared<hdf5::Pages>(hdf5::pages_of(lichtenberg::OpenFile(file.string())));
  hdf5::check(H5Ldelete(hdf5::open_in_memory(interrupted), "summary", H5P_DEFAULT));
  lichtenberg::write_sealed(file.string(), *interrupted);
  folder.write("charged.toml", replaced(charged_scene, "time = 0.2", stop));
  CHECK(ensemble(folder, "charged.toml").status == 0);
  CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>{"finished"});
}

TEST_CASE("ensemble: a member with changed settings fails and its file stays") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "neutral.toml --seeds 1 --vary population.count=1").status == 0);
  const std::string before = text_of(folder / "neutral-ensemble" / "count-1.h5");
  folder.write("neutral.toml", replaced(neutral_scene, "viscosity = 0.7", "viscosity = 0.8"));
  const Ended result = ensemble(folder, "neutral.toml --seeds 1 --vary population.count=1,2");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "count-1 failed: key `medium.viscosity` has changed"));
  CHECK(text_of(folder / "neutral-ensemble" / "count-1.h5") == before);
  CHECK(states(summary(folder, "neutral-ensemble")) == std::vector<std::string>{"failed", "finished"});
}

TEST_CASE("ensemble: members with damaged or foreign files fail, the files stay") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "neutral.toml --seeds 1 --vary population.count=2").status == 0);
  const fs::path out = folder / "neutral-ensemble";
  const std::string whole = text_of(out / "count-2.h5");
  folder.write("neutral-ensemble/count-1.h5", "something valuable");
  folder.write("neutral-ensemble/count-2.h5", whole.substr(0, whole.size() / 2));
  folder.write("neutral-ensemble/count-3.toml", "something valuable, too");
  const Ended result = ensemble(folder, "neutral.toml --seeds 1 --vary population.count=1,2,3,4");
  CHECK(result.status == 1);
  CHECK(contains(result.err, "count-1.h5 is no HDF5 file"));
  CHECK(contains(result.err, "count-2.h5 is damaged"));
  CHECK(contains(result.err, "count-3.toml exists and is not a scene"));
  CHECK(contains(result.err, "3 of 4 members failed"));
  CHECK(text_of(out / "count-1.h5") == "something valuable");
  CHECK(text_of(out / "count-3.toml") == "something valuable, too");
  CHECK(fs::exists(out / "count-4.h5"));
}

TEST_CASE("ensemble: a result with an empty dataset is reported as damaged") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "charged.toml").status == 0);
  const fs::path result = folder / "charged-ensemble" / "charged.h5";
  const std::string whole = text_of(result);
  namespace hdf5 = lichtenberg::hdf5;
  for (const std::string name : {"observables/field_solves/value", "summary/time"}) {
    CAPTURE(name);
    folder.write("charged-ensemble/charged.h5", whole);
    const hdf5::Handle file = hdf5::load(result.string());
    hdf5::put<double>(file, name, std::span<const double>(), {0}, "1");
    lichtenberg::write_atomically(result.string(), hdf5::image(file));
    const Ended ended = ensemble(folder, "charged.toml");
    CHECK(ended.status == 1);
    CHECK(contains(ended.err, "charged.h5 is damaged ("));
    CHECK(contains(ended.err, " is empty)"));
  }
}

TEST_CASE("ensemble: impossible members fail with a message and the others run") {
  const ScenesFolder folder;
  const Ended result =
      ensemble(folder, "neutral.toml --vary population.count=1,1000 --vary population.min_gap=0.0,1.0");
  CHECK(result.status == 1);
  CHECK(states(summary(folder, "neutral-ensemble")) ==
        std::vector<std::string>{"finished", "failed", "failed", "failed"});
  CHECK(contains(result.err, "count-1_min_gap-1 failed: "));
  CHECK(contains(result.err, "there is no space for even one"));
  CHECK(contains(result.err, "population.count = 1000 is impossible"));
  CHECK(contains(text_of(folder / "neutral-ensemble" / "count-1000_min_gap-0.toml"), "count = 1000"));
}

TEST_CASE("ensemble: scenes with field.accuracy instead of field.cells run") {
  const ScenesFolder folder;
  folder.write("accurate.toml", replaced(charged_scene, "cells = 32", "accuracy = 0.05"));
  const Ended result = ensemble(folder, "accurate.toml --seeds 2 --set stop.time=0.01");
  CHECK_EQ(result.status, 0);
  CHECK(states(summary(folder, "accurate-ensemble")) == std::vector<std::string>{"finished", "finished"});
}

TEST_CASE("ensemble: a member that fails during its run is reported") {
  const ScenesFolder folder;
  // The conductor moves at 10 m/s towards a wall without contact force. Drag would stop it after 10 m/s m / gamma = 9
  // mm, which is outside.
  const std::string no_walls = replaced(charged_scene, "[effects.wall_contact]\n", "");
  folder.write("charged.toml",
               no_walls + "[[conductor]]\nposition = [1e-3, 7e-3]\nvelocity = [0.0, 0.0]\nradius = 0.6e-3\n");
  const Ended result = ensemble(folder, "charged.toml --vary 'conductor.velocity=[0.0,0.0],[-10.0,0.0]' --quiet");
  CHECK(result.status == 1);
  INFO(result.err);
  CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>{"finished", "failed"});
  CHECK(contains(summary(folder, "charged-ensemble")["members"][1]["sentence"], "domain"));
  CHECK(contains(result.err, "1 of 2 members failed"));
}

TEST_CASE("ensemble: an invalid command gives one message and status 2") {
  const ScenesFolder folder;
  const auto check_refused = [&](const std::string& arguments, const std::string& part) {
    const Ended result = ensemble(folder, arguments);
    INFO(result.err);
    CHECK(result.status == 2);
    CHECK(result.err.find('\n') == result.err.size() - 1);
    CHECK(contains(result.err, part));
    CHECK_FALSE(fs::exists(folder / "neutral-ensemble"));
  };
  check_refused("nowhere.toml", "nowhere.toml");
  check_refused("neutral.toml --vary population.cuont=1", "population.count");
  check_refused("neutral.toml --vary population.count", "it must be KEY=VALUE,VALUE");
  check_refused("neutral.toml --vary population.count=many", "no list of values");
  check_refused("neutral.toml --conductors 1,1", "given twice");
  check_refused("neutral.toml --vary stop.time=0.01,nan", "neutral.toml: stop.time = nan is not allowed");
  check_refused("neutral.toml --vary medium.viscosity=1.0,-1.0", "medium.viscosity = -1 is not allowed");
  check_refused("neutral.toml --seeds 2 --vary medium.viscosity=1.0,true",
                "medium.viscosity = true has the wrong unit or type");
  check_refused("neutral.toml --conductors 1 --vary population.count=2", "varied twice");
  check_refused("neutral.toml --conductors 1 --vary population[0].count=2", "varied twice");
  check_refused("neutral.toml --conductors 2000,3000", "no member of this ensemble is possible");
  check_refused("neutral.toml --seeds 0", "--seeds");
  check_refused("neutral.toml --seeds 1000000000",
                "--seeds 1000000000 is not allowed: at most 100000 seeds are allowed");
  check_refused("neutral.toml --seeds 60000 --conductors 1,2", "the ensemble has 120000 members: at most 100000");
  check_refused("neutral.toml --out neutral.toml", "neutral.toml");
  check_refused("neutral.toml --petsc -ksp_view", "ensemble passes no options to PETSc");
}

TEST_CASE("ensemble: varying a key under its old and its new name is refused") {
  const ScenesFolder folder;
  const Ended result = ensemble(folder, "neutral.toml --vary conductor.held=true --vary conductor.fixed=false");
  CHECK(result.status == 2);
  CHECK(contains(result.err, "conductor.held is an old name: it is called conductor.fixed now\n"));
  CHECK(contains(result.err, "conductor.fixed is varied twice"));
}

TEST_CASE("ensemble: names of scene and folder may begin with a dash") {
  const ScenesFolder folder;
  fs::copy_file(folder / "neutral.toml", folder / "-neutral.toml");
  const Ended result = ensemble(folder, "--out=-out -- -neutral.toml");
  CHECK_MESSAGE(result.status == 0, result.err);
  CHECK(states(summary(folder, "-out")) == std::vector<std::string>{"finished"});
}

TEST_CASE("ensemble: a folder in use by another ensemble is refused") {
  const ScenesFolder folder;
  REQUIRE(ensemble(folder, "neutral.toml").status == 0);
  const int lock = open((folder / "neutral-ensemble" / ".lock").c_str(), O_RDWR);
  REQUIRE(flock(lock, LOCK_EX | LOCK_NB) == 0);
  const Ended result = ensemble(folder, "neutral.toml");
  CHECK(result.status == 2);
  CHECK(contains(result.err, "another ensemble is at work"));
  close(lock);
  CHECK(ensemble(folder, "neutral.toml").status == 0);
}

TEST_CASE("ensemble: sweeps of different keys in one folder have separate tables") {
  const ScenesFolder folder;
  const std::string in_one = "ensemble charged.toml --out both --quiet --set stop.time=0.01 ";
  const auto members = [&](const std::string& table) {
    return nlohmann::json::parse(text_of(folder / ("both/" + table)))["members"].size();
  };
  REQUIRE(run_program(folder, in_one + "--seeds 2").status == 0);
  REQUIRE(run_program(folder, in_one + "--conductors 3").status == 0);
  CHECK(members("ensemble.json") == 2);
  CHECK(members("ensemble-2.json") == 1);
  REQUIRE(run_program(folder, in_one + "--seeds 3").status == 0);
  REQUIRE(run_program(folder, in_one + "--conductors 3,4").status == 0);
  CHECK(members("ensemble.json") == 3);
  CHECK(members("ensemble-2.json") == 2);
  CHECK_FALSE(fs::exists(folder / "both/ensemble-3.json"));
}

TEST_CASE("ensemble --share k/n: runs one n-th of the members; tabulated later") {
  const ScenesFolder folder;
  const std::string command = "ensemble charged.toml --seeds 5 --out parts --quiet --set stop.time=0.01";
  const auto results = [&] {
    return std::ranges::count_if(fs::directory_iterator(folder / "parts"),
                                 [](const auto& entry) { return entry.path().extension() == ".h5"; });
  };
  REQUIRE(run_program(folder, command + " --share 2/3").status == 0);
  CHECK(results() == 2);  // The second and the fifth member.
  CHECK_FALSE(fs::exists(folder / "parts/ensemble.json"));
  for (const std::string share : {"1/3", "3/3"})
    REQUIRE(run_program(folder, command + " --share " + share).status == 0);
  CHECK(results() == 5);
  const Ended gathered = run_program(folder, command);
  CHECK(gathered.status == 0);
  CHECK(contains(gathered.out, "5 of 5 runs"));
  CHECK(fs::exists(folder / "parts/ensemble.json"));
  for (const std::string share : {"0/3", "4/3", "3", "a/3", "1/3x"})
    CHECK(run_program(folder, command + " --share " + share).status == 2);
}

TEST_CASE("ensemble: SIGINT stops members at checkpoints; they can be resumed") {
  const ScenesFolder folder;
  folder.write("charged.toml",
               replaced(charged_scene, "time = 0.2", "time = 20"));  // A thousand times the duration of this test.
  const fs::path out = folder / "charged-ensemble";
  const pid_t process = fork();
  if (process == 0) {
    if (chdir(folder.path.c_str()) != 0 || std::freopen("err", "w", stderr) == nullptr) _exit(99);
    execl(LICHTENBERG_BINARY, "lichtenberg", "ensemble", "charged.toml", "--seeds", "4", "--jobs", "2", nullptr);
    _exit(99);
  }
  const auto started = [&] {
    std::vector<fs::path> results;
    for (const char* name : {"seed-3.h5", "seed-4.h5", "seed-5.h5", "seed-6.h5"})
      if (fs::exists(out / name)) results.push_back(out / name);
    return results;
  };
  while (started().size() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(process, SIGINT);
  int status = 0;
  waitpid(process, &status, 0);
  CHECK(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == SIGINT);
  CHECK(contains(text_of(folder / "err"), "stopping: the members end after their present steps"));
  CHECK(contains(text_of(folder / "err"), "the same command goes on"));
  CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>(4, "stopped"));
  const std::vector<fs::path> interrupted = started();
  REQUIRE(interrupted.size() == 2);  // Waiting members were not started.
  for (const fs::path& result : interrupted) CHECK(last_time(result) < 20);

  const double stop = std::max(last_time(interrupted[0]), last_time(interrupted[1])) + 0.1;
  folder.write("charged.toml", replaced(charged_scene, "time = 0.2", fmt::format("time = {}", stop)));
  CHECK(ensemble(folder, "charged.toml --seeds 4").status == 0);
  CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>(4, "finished"));
  for (const fs::path& result : interrupted) {
    CHECK(last_time(result) == doctest::Approx(stop));
    CHECK(sessions(result) == 2);
  }
}

TEST_CASE("ensemble --device: overrides field.device of the scene") {
  // Without a device, a run that requests one is refused.
  const Folder folder;
  const std::string on_device = replaced(charged_scene, "cells = 32", "cells = 32\ndevice = \"cuda\"");
  folder.write("charged.toml", replaced(on_device, "time = 0.2", "time = 0.01"));
  const Ended ended = ensemble(folder, "charged.toml --seeds 2 --device cpu");
  CHECK_MESSAGE(ended.status == 0, ended.err);
  CHECK(states(summary(folder, "charged-ensemble")) == std::vector<std::string>(2, "finished"));
}

}  // namespace ensemble_test
