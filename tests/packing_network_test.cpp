// Tests of `lichtenberg network`: from a result file to the resistance of its particles, and back into the file.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/network/electrode.hpp"
#include "src/commands/command_line.hpp"
#include "src/commands/packing_network.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/recorder.hpp"
#include "tests/commands.hpp"
#include "tests/folder.hpp"
#include "tests/frames.hpp"

namespace packing_network_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;
using doctest::Approx;

namespace {

/// Temporary result file of one test. Three spheres of radius 1 m form a column between bottom and top with an overlap
/// of 10 %. One sphere of 0.5 m touches only the middle one, and one touches none. In the earlier frame the column is
/// open in the middle.
class TwoFrames {
 public:
  explicit TwoFrames(const std::string& network_table = "") : scene_(parse_scene(text(network_table), "column.toml")) {
    Recorder recorder = Recorder::start(path(), scene_, std::vector<double>(5, 1.0), false);
    for (const double x : {5.0, 2.0}) add_frame(recorder, x);
    recorder.save({});
  }
  std::string path() const { return (folder_ / "column.h5").string(); }
  /// Returns true if the folder contains no other file.
  bool alone() const { return std::distance(std::filesystem::directory_iterator(folder_.path), {}) == 1; }
  /// Resumes the run.
  void save_another_frame() const {
    Recorder recorder = Recorder::resume(path(), scene_);
    add_frame(recorder, 1);
    recorder.save({});
  }

 private:
  static std::string text(const std::string& network_table) {
    return "domain = { size = [8.0, 5.4] }\nfield = { cells = 400 }\n" + network_table +
           "[[conductor]]\nposition = [2.0, 1.0]\nradius = 1.0\n"
           "[[conductor]]\nposition = [4.0, 2.7]\nradius = 1.0\n"
           "[[conductor]]\nposition = [2.0, 4.3]\nradius = 1.0\n"
           "[[conductor]]\nposition = [6.0, 4.3]\nradius = 0.5\n"
           "[[conductor]]\nposition = [7.0, 2.0]\nradius = 0.5\n";
  }
  /// `x` is that of the middle sphere (m).
  static void add_frame(Recorder& recorder, double x) {
    ConductorFrame frame;
    frame.time = 5 - x;
    frame.position = {{2, 0.9}, {x, 2.7}, {2, 4.5}, {x + 1.4, 2.7}, {7.4, 1}};
    frame.velocity = frame.force = std::vector<Vec3>(5);
    frame.group = {0, 1, 2, 3, 4};
    recorder.add(columns_of(frame, {}));
  }

  Folder folder_;
  Scene scene_;
};

/// Result of three disks that touch each other and no wall.
void triangle(const std::string& path) {
  const Scene scene = parse_scene(
      "domain = { size = [6.0, 6.0] }\nfield = { cells = 400 }\n"
      "[[conductor]]\nposition = [2.0, 2.0]\nradius = 1.0\n"
      "[[conductor]]\nposition = [4.0, 2.0]\nradius = 1.0\n"
      "[[conductor]]\nposition = [3.0, 3.8]\nradius = 1.0\n",
      "triangle.toml");
  ConductorFrame frame;
  frame.position = {{2, 2}, {3.9, 2}, {2.95, 3.6}};
  frame.velocity = frame.force = std::vector<Vec3>(3);
  frame.group = {0, 1, 2};
  Recorder recorder = Recorder::start(path, scene, std::vector<double>(3, 1.0), false);
  recorder.add(columns_of(frame, {}));
  recorder.save({});
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("solve_network: known resistances, backbone and dead ends of a column") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  CHECK(frame.frame == 1);
  const SolvedNetwork particle = solve_network(frame, NetworkModel::particle, {}, 12);
  // The particle-centred network has four contacts of 1 Ohm, including those with the walls. The contact-centred one
  // has 1 Ohm across the lower and the upper particle. Across the middle one with its three contacts there is 1 Ohm in
  // parallel to 2 Ohm through the third.
  CHECK(particle.conduction.resistance == Approx(4).epsilon(1e-14));
  CHECK(particle.conduction.current == Approx(3).epsilon(1e-14));
  CHECK(particle.conduction.power == Approx(36).epsilon(1e-14));
  CHECK(solve_network(frame, NetworkModel::contact, {}, 12).conduction.resistance == Approx(8.0 / 3).epsilon(1e-14));
  for (const NetworkModel model : {NetworkModel::particle, NetworkModel::contact}) {
    const SolvedNetwork solved = solve_network(frame, model, {}, 1);
    CHECK(solved.backbone == std::vector<int>{0, 1, 2});
    CHECK(solved.dead_ends == std::vector<int>{3});
    CHECK(solved.isolated == std::vector<int>{4});
  }
}

TEST_CASE("network of a frame without a path: infinite resistance, no error") {
  const TwoFrames file;
  const SolvedNetwork solved = solve_network(read_packing(file.path(), 0), NetworkModel::particle, {}, 1);
  CHECK(!solved.conduction.connected);
  CHECK(std::isinf(solved.conduction.resistance));
  CHECK(solved.isolated == std::vector<int>{1, 3, 4});
  CHECK(run_command_line({"network", file.path(), "--frame", "0", "--no-picture"}) == 0);
  CHECK(run_command_line({"network", file.path(), "--frame", "0", "--no-picture", "--json"}) == 0);
}

TEST_CASE("network electrodes by number and name: give the known resistances") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  CHECK(solve_network(frame, NetworkModel::particle, {.between = "0,2"}, 1).conduction.resistance ==
        Approx(2).epsilon(1e-14));
  CHECK(solve_network(frame, NetworkModel::contact, {.between = "0,2"}, 1).conduction.resistance ==
        Approx(2.0 / 3).epsilon(1e-14));
  for (const char* between : {"3,top", "3, top", "3 ,top", " 3 , top "})
    CHECK(solve_network(frame, NetworkModel::particle, {.between = between}, 1).conduction.resistance ==
          Approx(3).epsilon(1e-14));
  for (const NetworkModel model : {NetworkModel::particle, NetworkModel::contact}) {
    const SolvedNetwork solved = solve_network(frame, model, {.between = "0,2"}, 1);
    CHECK(solved.backbone == std::vector<int>{0, 1, 2});
    CHECK(solved.dead_ends == std::vector<int>{3});
    CHECK(solved.isolated == std::vector<int>{4});
    const SolvedNetwork open = solve_network(frame, model, {.between = "0,4"}, 1);
    CHECK(open.backbone.empty());
    CHECK(open.dead_ends == std::vector<int>{0, 1, 2, 3, 4});
  }
}

TEST_CASE("network, touching electrodes: gives only the particle-centred network") {
  const Folder folder;
  triangle(folder / "triangle.h5");
  // Two contacts of 1 Ohm in series, in parallel to a third.
  const Ended words = run(folder, "network triangle.h5 --terminals 0,1 --no-picture");
  CHECK_EQ(words.status, 0);
  CHECK(contains(words.out, "effective resistance  0.666666666667 Ohm"));
  CHECK(contains(words.out, "contact-centred network: none, since the electrodes, particles 0 and 1, touch"));
  const Ended json = run(folder, "network triangle.h5 --terminals 0,1 --no-save --json");
  const auto found = nlohmann::json::parse(json.out);
  REQUIRE_EQ(found["networks"].size(), 1);
  CHECK(found["networks"][0]["resistance"].get<double>() == Approx(2.0 / 3).epsilon(1e-14));
  CHECK(contains(found["no_contact_network"].get<std::string>(), "touch"));
  check_refused(run(folder, "network triangle.h5 --terminals 0,1 --model contact"), "particles 0 and 1, touch");
}

TEST_CASE("network, touching electrodes: removes a stored contact-centred network") {
  const TwoFrames file;
  const auto has = [&](const char* model) {
    return hdf5::exists(hdf5::load(file.path()), std::string("network/") + model);
  };
  CHECK(run_command_line({"network", file.path(), "--no-picture"}) == 0);
  CHECK(has("contact"));
  CHECK(run_command_line({"network", file.path(), "--no-picture", "--terminals", "0,1"}) == 0);
  CHECK(has("particle"));
  CHECK_FALSE(has("contact"));
  // A particle and the wall that it touches.
  CHECK(run_command_line({"network", file.path(), "--no-picture", "--terminals", "bottom,0"}) == 0);
  CHECK(run_command_line({"network", file.path(), "--no-picture", "--terminals", "bottom,0", "--model", "contact"}) ==
        2);
}

TEST_CASE("resistances_to_all: equal the resistances of individual pairs") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  for (const NetworkModel model : {NetworkModel::particle, NetworkModel::contact})
    for (const std::string from : {"0", "bottom", "4"}) {
      CAPTURE(from);
      const std::vector<double> found = resistances_to_all(frame, model, {.between = from}).resistance;
      REQUIRE(found.size() == 5);
      for (int i = 0; i < 5; ++i) {
        const std::string pair = from + "," + std::to_string(i);
        if (std::to_string(i) == from)
          CHECK(found[i] == 0);
        else if (model == NetworkModel::contact && !contact_network_obstacle(frame, {.between = pair}).empty())
          CHECK(std::isnan(found[i]));
        else
          CHECK(1 / found[i] ==
                Approx(solve_network(frame, model, {.between = pair}, 1).conduction.conductance).epsilon(1e-14));
      }
    }
}

TEST_CASE("network --terminals 0,all: a triangle of 1 Ohm contacts gives 2/3 Ohm") {
  const Folder folder;
  triangle(folder / "triangle.h5");
  const std::string before = text_of(folder / "triangle.h5");
  for (const std::string between : {"0,all", "\"0, all\""}) {
    const auto found = nlohmann::json::parse(run(folder, "network triangle.h5 --json --terminals " + between).out);
    const auto resistance = found["networks"][0]["resistance"].get<std::vector<double>>();
    CHECK(resistance[0] == 0);
    for (const int i : {1, 2}) CHECK(resistance[i] == Approx(2.0 / 3).epsilon(1e-14));
    CHECK_EQ(found["networks"][1]["touching"], nlohmann::json({1, 2}));
  }
  CHECK(contains(run(folder, "network triangle.h5 --terminals 0,all").out, "Ohm from particle 0 to each particle"));
  CHECK(text_of(folder / "triangle.h5") == before);
  for (const std::string option : {"--voltage 2", "--out a.png", "--overwrite"})
    check_refused(run(folder, "network triangle.h5 --terminals 0,all " + option), "is not allowed with --terminals");
  check_refused(run(folder, "network triangle.h5 --terminals 0,1 --no-picture --overwrite"),
                "--overwrite is not allowed where no file is written: it is for use with a picture or --json=FILE");
  check_refused(run(folder, "analyse triangle.h5 --overwrite"), "--overwrite is not allowed where no file is written");
  check_refused(run(folder, "network triangle.h5 --terminals 3,all"), "there is no particle 3; allowed are 0 to 2");
  check_refused(run(folder, "network triangle.h5 --terminals lid,all"), "there is no wall \"lid\"");
}

TEST_CASE("resistances_to_all: more than 20000 eliminations are refused") {
  PackingFrame frame;
  const int count = 20'001;
  frame.packing.position.resize(count);
  frame.packing.radius.assign(count, 0.1);
  for (int i = 0; i < count; ++i) frame.packing.position[i][0] = i;
  CHECK(std::isinf(resistances_to_all(frame, NetworkModel::particle, {.between = "0"}).resistance[1]));
  CHECK_THROWS_WITH_AS(resistances_to_all(frame, NetworkModel::contact, {.between = "0"}),
                       doctest::Contains("at most 20000 are allowed: --model particle"), InputError);
}

TEST_CASE("network output: states an assumed resistor and where each model applies") {
  const Folder folder;
  triangle(folder / "triangle.h5");
  const std::string command = "network triangle.h5 --terminals bottom,top --no-save ";
  const std::string assumed = "resistance = 1 Ohm: assumed, since neither --resistor nor [network] names a model";
  CHECK(contains(run(folder, command).out, assumed));
  for (const std::string option : {"--resistance 1", "--resistor constant --resistance 1"}) {
    const Ended given = run(folder, command + option);
    CHECK(contains(given.out, "resistance = 1 Ohm\n"));
    CHECK(contains(given.out, "right where           contacts resist, and particles hardly do\n"));
    CHECK(contains(given.out, "right where           particles resist, and contacts do not"));
  }
  const auto json = nlohmann::json::parse(run(folder, command + "--json").out);
  CHECK_EQ(json["networks"][0]["assumed"], true);
  CHECK_EQ(nlohmann::json::parse(run(folder, command + "--json --resistance 1").out)["networks"][0]["assumed"], false);
}

TEST_CASE("[network] of the scene: sets the resistor model, options replace it") {
  const TwoFrames file(
      "[network]\nresistor = \"constriction\"\nresistivity = 3.0\ncontact_radius = 0.01\nmodel = \"contact\"\n");
  const PackingFrame frame = read_packing(file.path(), {});
  CHECK(frame.scene.network.model == NetworkModel::contact);
  const SolvedNetwork solved = solve_network(frame, NetworkModel::contact, frame.scene.network, 1);
  CHECK(solved.conduction.resistance == Approx(6 * 3.0 / (4 * 0.01)).epsilon(1e-13));
  // Another resistor on the command line ignores the scene's parameters and uses those given with it.
  CHECK(run_command_line({"network", file.path(), "--no-picture", "--resistor", "constant", "--resistance", "2"}) == 0);
  CHECK(run_command_line({"network", file.path(), "--no-picture", "--resistance", "2"}) == 2);
}

TEST_CASE("network power balance: holds for a current of 2.5e-308 A") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  const SolvedNetwork solved =
      solve_network(frame, NetworkModel::particle, {.parameters = {.resistance = 1e300}}, 1e-7);
  CHECK(solved.conduction.current == Approx(0.25e-307).epsilon(1e-14));
  CHECK(solved.conduction.power_balance < 1e-12);
}

TEST_CASE("network of two materials, 1e-30 and 1e30 Ohm: resistance is exact") {
  const TwoFrames file;
  PackingFrame frame = read_packing(file.path(), {});
  frame.packing.resistivity = {1e-30, 1e30, 1e-30, 1, 1};
  // From bottom to top, particle-centred, half of each contact lies in either particle: 1e30 twice, in series.
  const SolvedNetwork solved = solve_network(frame, NetworkModel::particle, {}, 1);
  CHECK(solved.conduction.resistance == Approx(1e30).epsilon(1e-14));
  CHECK(solved.conduction.power_balance < 1e-14);
}

TEST_CASE("save_networks: stores the solved network, keeps checkpoint and frames") {
  const TwoFrames file;
  for (const double voltage : {1.0, 12.0}) {  // The second call replaces the data of the first.
    const PackingFrame frame = read_packing(file.path(), {});
    save_networks(file.path(), frame, {solve_network(frame, NetworkModel::particle, {}, voltage)});
  }
  const hdf5::Handle result = hdf5::load(file.path());
  CHECK(hdf5::get<double>(result, "network/particle/effective_resistance")[0] == Approx(4));
  const auto current = hdf5::get<double>(result, "network/particle/current");
  const auto potential = hdf5::get<double>(result, "network/particle/potential");
  const auto links = hdf5::get<std::int32_t>(result, "network/particle/links");
  const auto conductance = hdf5::get<double>(result, "network/particle/conductance");
  REQUIRE(current.size() == 5);
  for (std::size_t k = 0; k < current.size(); ++k)
    CHECK(current[k] ==
          Approx(conductance[k] * (potential[links[2 * k]] - potential[links[2 * k + 1]])).epsilon(1e-12));
  CHECK(hdf5::get<std::int32_t>(result, "network/particle/isolated") == std::vector<std::int32_t>{4});
  CHECK(hdf5::exists(result, "checkpoint"));
  CHECK(hdf5::shape(result, "particles/conductors/position/value")[0] == 2);
}

TEST_CASE("save_networks: a result that changed since reading is not modified") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  const SolvedNetwork solved = solve_network(frame, NetworkModel::particle, {}, 1);
  file.save_another_frame();
  const std::string newer = text_of(file.path());
  CHECK_THROWS_AS(save_networks(file.path(), frame, {solved}), Failure);
  CHECK(text_of(file.path()) == newer);
  CHECK(file.alone());
}

TEST_CASE("network command: impossible measurements are refused with a message") {
  const TwoFrames file;
  const PackingFrame frame = read_packing(file.path(), {});
  const auto refused = [&](const NetworkOptions& options) {
    return message_of([&] { solve_network(frame, NetworkModel::particle, options, 1); });
  };
  CHECK(contains(refused({.between = "bottom,bottom"}), "same electrode twice"));
  CHECK(contains(refused({.between = "bottom"}), "two electrodes are needed"));
  CHECK(contains(refused({.between = "bottom,lid"}), "there is no wall \"lid\"; allowed are left, right, bottom, top"));
  CHECK(contains(refused({.between = "bottom,5"}), "there is no particle 5; allowed are 0 to 4"));
  const auto in_periodic_box = [] { network::read_electrode("lid", {}, 5); };
  CHECK(contains(message_of(in_periodic_box), "there is no wall \"lid\"; particles by number are allowed"));
  CHECK(contains(refused({.resistor = "length"}), "needs resistance_per_length in Ohm/m"));
  CHECK(contains(refused({.parameters = {.resistance = -1}}), "greater than 0"));
  CHECK(contains(refused({.parameters = {.resistance = INFINITY}}),
                 "inf Ohm is not allowed: it must be greater than 0 and finite"));
  CHECK(contains(refused({.parameters = {.contact_radius = 0.1}}), "\"constant\" does not use contact_radius"));
  for (const NetworkModel model : {NetworkModel::particle, NetworkModel::contact}) {
    const NetworkOptions wide{.resistor = "constriction", .parameters = {.resistivity = 1, .contact_radius = 0.5}};
    CHECK(contains(message_of([&] { solve_network(frame, model, wide, 1); }),
                   "no contact can be that wide on particle 3 of radius 0.5 m"));
  }
  PackingFrame spheres = frame;
  spheres.packing.position[4][2] = 1;
  CHECK(contains(message_of([&] {
                   solve_network(spheres, NetworkModel::contact,
                                 {.resistor = "disk", .parameters = {.sheet_resistance = 1, .contact_radius = 0.01}},
                                 1);
                 }),
                 "disks in the plane"));
  CHECK(contains(refused({.resistor = "disk", .parameters = {.sheet_resistance = 1, .contact_radius = 0.01}}),
                 "contact-centred"));
  CHECK(contains(message_of([&] { solve_network(frame, NetworkModel::contact, {.between = "0,1"}, 1); }), "touch"));
  CHECK(contains(message_of([&] { read_packing(file.path(), 2); }), "it has frames 0 to 1"));
  CHECK(contains(message_of([] { read_packing("nothing.h5", {}); }), "nothing.h5 does not exist"));
  CHECK(contains(message_of([] {
                   parse_scene(
                       "domain = { size = [1.0, 1.0] }\n[network]\nresistor = \"length\"\n"
                       "[[conductor]]\nposition = [0.5, 0.5]\nradius = 0.1\n",
                       "x.toml");
                 }),
                 "needs resistance_per_length"));
  const std::string before = text_of(file.path());
  for (const std::string voltage : {"0", "-1", "1e-200", "1e200", "inf", "nan"})
    CHECK(run_command_line({"network", file.path(), "--voltage", voltage}) == 2);
  CHECK(run_command_line({"network", file.path(), "--resistance", "inf"}) == 2);
  CHECK(run_command_line({"network", file.path(), "--resistivity", "1"}) == 2);
  // The refusal precedes the solution and its storage.
  CHECK(run_command_line({"network", file.path(), "--out", file.path() + "/nowhere/picture.png"}) == 2);
  const std::string picture = file.path().substr(0, file.path().size() - 3) + "-network-contact.png";
  std::ofstream(picture) << "mine";
  CHECK(run_command_line({"network", file.path(), "--model", "contact"}) == 2);
  CHECK(text_of(picture) == "mine");
  CHECK(text_of(file.path()) == before);
  for (const double part : {0.9, 0.5, 0.1}) {
    const auto length = static_cast<std::size_t>(part * static_cast<double>(before.size()));
    std::ofstream(file.path(), std::ios::binary) << before.substr(0, length);
    CHECK(contains(message_of([&] { read_packing(file.path(), {}); }), "column.h5 is damaged"));
    CHECK(run_command_line({"network", file.path()}) == 2);
  }
}

}  // namespace packing_network_test
