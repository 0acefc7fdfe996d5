// Tests of the command analyse with the built program on result files with given frames.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result.hpp"
#include "tests/file_numbers.hpp"
#include "tests/frames.hpp"
#include "tests/near.hpp"
#include "tests/program.hpp"
#include "tests/source_folder.hpp"

namespace analyse_test {

using namespace lichtenberg;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// Scene of four spheres of radius 1 mm above a grounded side. Contacts close below 3 mm and open at 3.05 mm.
const std::string scene_text = R"(
title = "Four"
[domain]
size = [40e-3, 40e-3]
bottom = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [10e-3, 1.5e-3]
radius = 1e-3
[[conductor]]
position = [10e-3, 4e-3]
radius = 1e-3
[[conductor]]
position = [10e-3, 6.5e-3]
radius = 1e-3
[[conductor]]
position = [30e-3, 30e-3]
radius = 1e-3
[effects.floating_conductors]
[effects.current_injection]
current = 0.2e-9
[effects.stokes_drag]
[effects.contact_discharge]
contact_distance = 1e-3
)";

const std::vector<double> masses{3e-5, 3e-5, 3e-5, 3e-5};

ConductorFrame frame_at(double time, std::vector<Vec3> position) {
  ConductorFrame frame;
  frame.time = time;
  frame.position = std::move(position);
  frame.velocity.resize(4);
  frame.force.resize(4);
  frame.charge.resize(4);
  frame.potential = {0, 0, 0, 100};
  frame.group = {-1, -1, -1, 3};
  frame.energy = 5e-8;
  return frame;
}

/// A chain of three spheres and an isolated one.
ConductorFrame first_frame() { return frame_at(0, {{10e-3, 1.5e-3}, {10e-3, 4e-3}, {10e-3, 6.5e-3}, {30e-3, 30e-3}}); }

/// The isolated sphere has moved to 0 and 1, 3.02 mm from 0: hysteresis keeps this contact closed.
ConductorFrame second_frame() {
  ConductorFrame frame = first_frame();
  frame.time = 0.5;
  frame.position[3] = {10e-3 + std::sqrt(3.02 * 3.02 - 1) * 1e-3, 2.5e-3};
  frame.velocity[3] = {3e-3, 4e-3};
  frame.force[3] = {1e-6, 2e-6};
  frame.potential = {0, 0, 0, 40};
  frame.energy = 4.8e-8;
  return frame;
}

const std::vector<analysis::Edge> first_contacts{{0, analysis::to_ground}, {0, 1}, {1, 2}};
const std::vector<analysis::Edge> second_contacts{{0, analysis::to_ground}, {0, 1}, {0, 3}, {1, 2}, {1, 3}};

/// Saves a run with both frames.
Recorder saved_run(const std::string& path, const std::string& text = scene_text) {
  Recorder recorder = Recorder::start(path, parse_scene(text, "four.toml"), masses, false);
  recorder.add(columns_of(first_frame(), analysis::network(first_contacts, first_frame().position)));
  recorder.add(columns_of(second_frame(), analysis::network(second_contacts, second_frame().position)));
  recorder.save({});
  return recorder;
}

/// Resumes the run and adds a frame.
void add_a_frame(const std::string& path) {
  Recorder recorder = Recorder::resume(path, parse_scene(scene_text, "four.toml"));
  ConductorFrame third = second_frame();
  third.time = 1;
  recorder.add(columns_of(third, analysis::network(second_contacts, third.position)));
  recorder.save({});
}

/// Changes a file outside the program.
template <class Change>
void change(const std::string& path, Change apply) {
  const hdf5::Handle file = hdf5::load(path);
  apply(file);
  write_atomically(path, hdf5::image(file));
}

void remove_from(const hdf5::Handle& file, const std::string& name) {
  hdf5::check(H5Ldelete(file, name.c_str(), H5P_DEFAULT));
}

Ended analyse(const Folder& folder, const std::string& arguments) {
  return run_program(folder, "analyse " + arguments);
}

json analysed(const Folder& folder, const std::string& arguments) {
  const Ended ended = analyse(folder, arguments + " --json");
  INFO(ended.err);
  REQUIRE_EQ(ended.status, 0);
  return json::parse(ended.out);
}

/// Checks for one message, status 2, and an unchanged file.
void check_refused(const Folder& folder, const std::string& file, const std::string& part,
                   const std::string& options = "") {
  CAPTURE(file);
  const std::string before = text_of(folder / file);
  const Ended ended = analyse(folder, file + options);
  CAPTURE(ended.err);
  CHECK_EQ(ended.status, 2);
  CHECK(ended.out.empty());
  CHECK(ended.err.starts_with("lichtenberg: "));
  CHECK_EQ(ended.err.find('\n'), ended.err.size() - 1);
  CHECK_NE(ended.err.find(part), std::string::npos);
  CHECK(text_of(folder / file) == before);
}

}  // namespace

TEST_CASE("analyse: gives degrees, loops, Strahler numbers and tree of each frame") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const json answer = analysed(folder, "four.h5");
  CHECK_EQ(answer["title"], "Four");
  CHECK_EQ(answer["contacts_recorded"], true);
  REQUIRE_EQ(answer["frames"].size(), 2);
  const json &first = answer["frames"][0], &second = answer["frames"][1];

  CHECK_EQ(first["time"], 0);
  CHECK_EQ(first["connected"], 3);
  CHECK_EQ(first["grounded"], 1);
  CHECK_EQ(first["loops"], 0);
  CHECK_EQ(first["degree_number"], json({0, 1, 2, 0}));
  CHECK_EQ(first["endpoints"], 1);
  CHECK_EQ(first["branch_points"], 0);
  CHECK_EQ(first["strahler_number"], json({0, 3, 0}));
  CHECK_EQ(first["strahler"], json({1, 1, 1, 0}));
  CHECK_EQ(first["edge_length_in_radii"][5].get<double>(), near(2.5, 1e-12));  // The mean.
  CHECK_EQ(first["tree_length"].get<double>(), near(5e-3, 1e-12));
  CHECK_EQ(first["emst_degree_number"], json({0, 2, 2}));
  CHECK(first["box_dimension"].is_null());
  CHECK(first["power_dissipated"].is_null());

  // The neighbours are 0: ground, 1, 3; 1: 0, 2, 3; 2: 1; 3: 0, 1. Hysteresis keeps one loop closed.
  CHECK_EQ(second["connected"], 4);
  CHECK_EQ(second["loops"], 1);
  CHECK_EQ(second["degree_number"], json({0, 1, 1, 2}));
  CHECK_EQ(second["branch_fraction"], 0.5);
  CHECK_EQ(second["residual_7_7"].get<double>(), doctest::Approx(0).epsilon(1e-12));
  CHECK_EQ(second["residual_7_7_printed"].get<double>(), near(0.25 + 0.25, 1e-12));  // (1 + 2 + 3 + 3) / 4 - 2 + 1 / 4
  CHECK_EQ(second["strahler"], json({2, 1, 1, 1}));  // 3 and 1, to which 2 is attached, both connect to 0.
  CHECK_EQ(second["strahler_streams"], json({0, 2, 1}).get<std::vector<int>>());
}

TEST_CASE("analyse: computes power of drag, field and source from a frame's data") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const json answer = analysed(folder, "four.h5");
  const json& second = answer["frames"][1];
  const double drag = 6 * std::numbers::pi * 0.7 * 1e-3 * 25e-6, kinetic = 0.5 * 3e-5 * 25e-6;
  CHECK_EQ(second["power_drag"].get<double>(), near(drag, 1e-12));
  CHECK_EQ(second["power_field"].get<double>(), near(1e-6 * 3e-3 + 2e-6 * 4e-3, 1e-12));
  CHECK_EQ(second["power_source"].get<double>(), near(0.2e-9 * 40, 1e-12));
  CHECK_EQ(second["kinetic_energy"].get<double>(), near(kinetic, 1e-12));
  // The source supplied (20 nW + 8 nW) / 2, the field released 2 nJ in 0.5 s, and the motion has gained the kinetic
  // energy.
  CHECK_EQ(second["power_dissipated"].get<double>(), doctest::Approx(14e-9 + 4e-9 - kinetic / 0.5).epsilon(1e-9));
  CHECK_EQ(answer["units"]["power_dissipated"], "W");
}

TEST_CASE("analyse: energy stored in elastic contacts is not counted as dissipated") {
  const Folder folder;
  const std::string elastic =
      "[effects.hertz_contact]\nyoung = 200e9\npoisson = 0.3\n"
      "[effects.wall_contact]\nyoung = 100e9\npoisson = 0.3\n";
  ConductorFrame pressed = second_frame();
  const double overlap = 1e-7;  // Overlap of 2 and 3, and of 0 and the bottom.
  pressed.position[0].y = 1e-3 - overlap;
  pressed.position[3] = pressed.position[2] + Vec3{0, 2e-3 - overlap, 0};
  const std::vector<analysis::Edge> contacts{{0, analysis::to_ground}, {0, 1}, {1, 2}, {2, 3}};
  {
    const Scene scene = parse_scene(scene_text + elastic, "four.toml");
    Recorder recorder = Recorder::start(folder / "four.h5", scene, masses, false);
    recorder.add(columns_of(first_frame(), analysis::network(first_contacts, first_frame().position)));
    recorder.add(columns_of(pressed, analysis::network(contacts, pressed.position)));
    recorder.save({});
  }
  // Hertz: 8/15 E* sqrt(R_eff) overlap^(5/2), 1/E* = (1 - poisson^2) (1 / young_a + 1 / young_b).
  const auto energy = [&](double young_a, double young_b, double radius) {
    const double modulus = 1 / ((1 - 0.09) * (1 / young_a + 1 / young_b));
    return 8.0 / 15 * modulus * std::sqrt(radius) * std::pow(overlap, 2.5);
  };
  const double stored = energy(200e9, 200e9, 0.5e-3) + energy(200e9, 100e9, 1e-3), kinetic = 0.5 * 3e-5 * 25e-6;
  const json second = analysed(folder, "four.h5")["frames"][1];
  // An overlap is a difference of stored lengths 1e5 times as large: a relative error of 1e-11.
  CHECK_EQ(second["elastic_energy"].get<double>(), doctest::Approx(stored).epsilon(1e-9).scale(0));
  CHECK_EQ(second["power_dissipated"].get<double>(),
           doctest::Approx(14e-9 + 4e-9 - (kinetic + stored) / 0.5).epsilon(1e-9).scale(0));
}

TEST_CASE("analyse: dissipated power is null if an electrode is not at 0 V") {
  const Folder folder;
  std::string text = scene_text;
  text.replace(text.find("potential = 0.0"), 15, "potential = 5.0");
  saved_run(folder / "four.h5", text);
  CHECK(analysed(folder, "four.h5")["frames"][1]["power_dissipated"].is_null());
}

TEST_CASE("analyse: keeps the recorded dissipated power and currents of a circuit") {
  const Folder folder;
  saved_run(folder / "four.h5");
  change(folder / "four.h5", [](const hdf5::Handle& file) {
    const hdf5::Handle power = hdf5::open_group(file, "observables/dissipated_power");
    hdf5::put<double>(power, "value", std::array{std::nan(""), 7e-6}, {2}, "W");
    const hdf5::Handle current = hdf5::open_group(file, "observables/current");
    hdf5::put<double>(current, "value", std::array{1e-9, -1e-9, 2e-9, -2e-9}, {2, 2}, "A");
  });
  CHECK_EQ(analysed(folder, "four.h5 --frame 1")["frames"][0]["power_dissipated"], 7e-6);
  const json answer = analysed(folder, "four.h5");
  CHECK(answer["frames"][0]["dissipated_power"].is_null());
  CHECK_EQ(answer["frames"][1]["dissipated_power"], 7e-6);
  CHECK_EQ(answer["frames"][1]["current"], json({2e-9, -2e-9}));
  CHECK_EQ(answer["units"]["current"], "A");
  CHECK_FALSE(answer["units"].contains("entropy_production"));  // This file does not have the quantity.
  CHECK_EQ(hdf5::get<double>(hdf5::load(folder / "four.h5"), "analysis/current"),
           std::vector{1e-9, -1e-9, 2e-9, -2e-9});
  const Ended ended = analyse(folder, "four.h5");
  CHECK_NE(ended.out.find("current 2e-09, -2e-09 A"), std::string::npos);
}

TEST_CASE("analyse: stored numbers equal printed ones; other data stay unchanged") {
  const Folder folder;
  saved_run(folder / "four.h5");
  auto before = numbers_in(folder / "four.h5");
  const json answer = analysed(folder, "four.h5");
  {
    const hdf5::Handle file = hdf5::load(folder / "four.h5");
    for (const auto& [name, unit] : answer["units"].items()) {
      CAPTURE(name);
      const std::vector<double> stored = hdf5::get<double>(file, "analysis/" + name);
      std::vector<double> printed;
      for (const json& frame : answer["frames"]) {
        const json values = frame[name].is_array() ? frame[name] : json::array({frame[name]});
        for (const json& value : values) printed.push_back(value.is_null() ? NAN : value.get<double>());
      }
      REQUIRE_EQ(stored.size(), printed.size());
      for (std::size_t k = 0; k < stored.size(); ++k)
        CHECK((stored[k] == printed[k] || (std::isnan(stored[k]) && std::isnan(printed[k]))));
    }
    CHECK_EQ(hdf5::names(hdf5::open_group(file, "analysis")).size(), answer["units"].size());
  }
  auto after = numbers_in(folder / "four.h5");
  std::erase_if(after, [](const auto& entry) { return entry.first.starts_with("/analysis/"); });
  CHECK(before == after);

  // A repetition gives the same numbers, and the file does not grow.
  const auto once = numbers_in(folder / "four.h5");
  const auto size = fs::file_size(folder / "four.h5");
  CHECK_EQ(analyse(folder, "four.h5").status, 0);
  CHECK(numbers_in(folder / "four.h5") == once);
  CHECK_LE(fs::file_size(folder / "four.h5"), size + 4096);  // Attributes are written again.
  for (const auto& entry : fs::directory_iterator(folder.path))
    CHECK(entry.path().string().find(".partial") == std::string::npos);
}

TEST_CASE("analyse --frame: prints one frame and stores nothing in the file") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const std::string before = text_of(folder / "four.h5");
  const json answer = analysed(folder, "four.h5 --frame 1");
  REQUIRE_EQ(answer["frames"].size(), 1);
  CHECK_EQ(answer["frames"][0]["frame"], 1);
  CHECK_EQ(answer["frames"][0]["power_dissipated"], analysed(folder, "four.h5")["frames"][1]["power_dissipated"]);
  const Folder other;
  saved_run(other / "four.h5");
  CHECK_EQ(analyse(other, "four.h5 --frame 0").status, 0);
  CHECK(text_of(other / "four.h5").size() == before.size());
  CHECK_FALSE(hdf5::exists(hdf5::load(other / "four.h5"), "analysis"));
}

TEST_CASE("analyse: prints a line per frame and details of the last frame") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const Ended ended = analyse(folder, "four.h5");
  CHECK_EQ(ended.status, 0);
  for (const std::string part :
       {"Four, 4 conductors, 2 frames, contacts as recorded", "\n     0 ", "\n     1 ", "frame 1 at t = 0.5 s",
        "order 2", "7.7", "EMST", "D of boxes", "dissipated", "stored         four.h5:/analysis, all 2 frames"})
    CHECK_MESSAGE(ended.out.find(part) != std::string::npos, part);
}

TEST_CASE("analyse: unrecorded contacts follow from distances and the recorded tree") {
  const Folder folder;
  saved_run(folder / "four.h5");
  change(folder / "four.h5", [](const hdf5::Handle& file) {
    remove_from(file, "network/contacts_of_all_frames");
    remove_from(file, "network/contacts_end");
  });
  const json answer = analysed(folder, "four.h5");
  CHECK_EQ(answer["contacts_recorded"], false);
  const json &first = answer["frames"][0], &second = answer["frames"][1];
  CHECK_EQ(first["degree_number"], json({0, 1, 2, 0}));
  // The recorded tree connects 3 to 0 through hysteresis. The contact of 1 and 3, 3.2 mm apart, is not recorded.
  CHECK_EQ(second["connected"], 4);
  CHECK_EQ(second["strahler"], json({2, 1, 1, 1}));
}

TEST_CASE("result of format 1: analyse and plot read it, run --resume refuses it") {
  const Folder now, earlier;
  saved_run(now / "four.h5");
  fs::copy_file(source_folder() + "/tests/format-1.h5", earlier / "four.h5");
  const json old = analysed(earlier, "four.h5");
  CHECK_EQ(old["contacts_recorded"], true);
  CHECK_EQ(old["frames"], analysed(now, "four.h5")["frames"]);
  CHECK_EQ(run_program(earlier, "plot four.h5 --frame 0").status, 0);
  CHECK(fs::exists(earlier / "four-frame-0-potential.png"));
  earlier.write("four.toml", scene_text);
  const Ended resumed = run_program(earlier, "run --resume four.toml");
  CHECK_EQ(resumed.status, 2);
  CHECK_NE(resumed.err.find(
               "four.h5 has result format 1, but with this version of lichtenberg only format 2 can be resumed"),
           std::string::npos);
}

TEST_CASE("resume: adding a frame removes the stored analysis of fewer frames") {
  const Folder folder;
  saved_run(folder / "four.h5");
  REQUIRE_EQ(analyse(folder, "four.h5").status, 0);
  add_a_frame(folder / "four.h5");
  CHECK_FALSE(hdf5::exists(hdf5::load(folder / "four.h5"), "analysis"));
  CHECK_EQ(analysed(folder, "four.h5")["frames"].size(), 3);
}

TEST_CASE("put_analysis: a result file that changed since reading is not modified") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const Result result(folder / "four.h5");
  add_a_frame(folder / "four.h5");
  const std::string newer = text_of(folder / "four.h5");
  CHECK_THROWS_AS(result.put_analysis({{"time", "s", Column::Of::list, 0, result.times()}}), Failure);
  CHECK(text_of(folder / "four.h5") == newer);
}

TEST_CASE("analyse: the result file of an active run is analysed but not changed") {
  const Folder folder;
  const Recorder recorder = saved_run(folder / "four.h5");
  const std::string before = text_of(folder / "four.h5");
  const Ended ended = analyse(folder, "four.h5");
  CHECK_EQ(ended.status, 1);
  CHECK_NE(ended.out.find("frame 1 at t = 0.5 s"), std::string::npos);
  CHECK_NE(ended.err.find("four.h5 is being written: try again once its run is over"), std::string::npos);
  CHECK(text_of(folder / "four.h5") == before);
}

TEST_CASE("analyse: unusable files or frame numbers give one message and status 2") {
  const Folder folder;
  CHECK_EQ(analyse(folder, "nowhere.h5").status, 2);
  CHECK_NE(analyse(folder, "nowhere.h5").err.find("nowhere.h5 does not exist"), std::string::npos);
  CHECK_EQ(analyse(folder, "").status, 2);
  saved_run(folder / "four.h5");
  const std::string whole = text_of(folder / "four.h5");

  folder.write("text.h5", "not a result");
  check_refused(folder, "text.h5", "is no HDF5 file");
  folder.write("empty.h5", "");
  check_refused(folder, "empty.h5", "is no HDF5 file");
  for (const double part : {0.9, 0.5, 0.1}) {
    folder.write("cut.h5", whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    check_refused(folder, "cut.h5", "cut.h5 is damaged");
  }
  write_atomically(folder / "other.h5", hdf5::image(hdf5::create_in_memory()));
  check_refused(folder, "other.h5", "was not written by `lichtenberg run`");
  folder.write("old.h5", whole);
  change(folder / "old.h5",
         [](const hdf5::Handle& file) { hdf5::put_attribute(file, "lichtenberg_result", result_format + 1); });
  check_refused(folder, "old.h5", fmt::format("has result format {}", result_format + 1));

  for (const std::string options : {" --frame 2", " --frame -1", " --frame 2 --json"})
    check_refused(folder, "four.h5", "it has frames 0 to 1", options);
}

TEST_CASE("analyse: result files with missing or inconsistent parts are refused") {
  const Folder folder;
  saved_run(folder / "four.h5");
  const std::string whole = text_of(folder / "four.h5");
  const auto without = [&](const std::string& name) {
    folder.write("less.h5", whole);
    change(folder / "less.h5", [&](const hdf5::Handle& file) { remove_from(file, name); });
  };
  without("particles/conductors/position");
  check_refused(folder, "less.h5", "holds no frames");
  without("particles/conductors/successor");
  check_refused(folder, "less.h5", "[effects.contact_discharge]");
  without("scene/text");
  check_refused(folder, "less.h5", "less.h5 is damaged");
  without("observables/energy");
  check_refused(folder, "less.h5", "less.h5 is damaged");
  without("particles/conductors/mass");
  change(folder / "less.h5", [](const hdf5::Handle& file) {
    hdf5::put<double>(file, "particles/conductors/mass", std::array{3e-5}, {1}, "kg");
  });
  check_refused(folder, "less.h5", "there are 1 masses of 4 conductors");

  folder.write("less.h5", whole);
  change(folder / "less.h5", [](const hdf5::Handle& file) { hdf5::put_text(file, "scene/text", "[domain]"); });
  check_refused(folder, "less.h5", "less.h5:/scene/text");
  change(folder / "less.h5", [](const hdf5::Handle& file) {
    std::string text = scene_text;
    text.erase(text.rfind("[[conductor]]"), text.find("[effects.floating") - text.rfind("[[conductor]]"));
    hdf5::put_text(file, "scene/text", text);
  });
  check_refused(folder, "less.h5", "its scene has 3 conductors, but its frames have 4");
  folder.write("less.h5", whole);
  change(folder / "less.h5", [](const hdf5::Handle& file) {
    hdf5::put<std::int64_t>(file, "network/contacts_end", std::array<std::int64_t, 2>{9, 3}, {2}, "1");
  });
  check_refused(folder, "less.h5", "less.h5 is damaged");
}

}  // namespace analyse_test
