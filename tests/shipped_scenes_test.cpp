// Runs every scene of scenes/, shortened, and compares it with the numbers in shipped_scenes.json. These are regression
// values of this program; validation/ tests their correctness. README.md describes how to update them.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/vary.hpp"
#include "tests/program.hpp"
#include "tests/source_folder.hpp"

namespace shipped_scenes_test {

using namespace lichtenberg;
namespace fs = std::filesystem;

namespace {

using json = nlohmann::ordered_json;  // An updated table keeps its order.

const fs::path source = source_folder();
const fs::path table_path = source / "tests" / "shipped_scenes.json";

json table() { return json::parse(text_of(table_path)); }

/// Quantities that count events. Rounding does not change them while the motion is not chaotic.
const std::set<std::string> counted{"branch_points", "collisions", "connected", "contacts",
                                    "endpoints",     "loops",      "rattlers"};

/// Quantities that count work. Rounding may add an iteration where a residual is close to the tolerance. It may add a
/// solve where a step's error estimate is close to its tolerance.
const std::set<std::string> work{"evaluations", "field_solves", "iterations"};

/// Largest permitted difference between a stored quantity and a computed one. `values` are those of the row.
double allowed(const std::string& name, const json& values, double tolerance) {
  const double value = std::abs(values.at(name).get<double>());
  if (counted.contains(name)) return 0;
  if (work.contains(name)) return std::max(2.0, 0.05 * value);
  // Sums of charges of both signs may vanish.
  if (name.starts_with("charge")) return tolerance * std::max(value, values.at("charge").get<double>());
  return tolerance * value;
}

double norm(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double number : numbers) sum += number * number;
  return std::sqrt(sum);
}

/// Adds norms of the particles' quantities in a result file. `way` (m) is the displacement from the first to the last
/// frame.
void add_particles(const hdf5::Handle& file, hsize_t last, json& values) {
  const auto read_frame = [&](const std::string& name, hsize_t frame) {
    return hdf5::get_rows<double>(file, "particles/conductors/" + name + "/value", frame, 1);
  };
  for (const char* name : {"position", "velocity", "charge", "potential"})
    if (hdf5::exists(file, std::string("particles/conductors/") + name)) values[name] = norm(read_frame(name, last));
  std::vector<double> displacement = read_frame("position", last);
  const std::vector<double> start = read_frame("position", 0);
  std::transform(displacement.begin(), displacement.end(), start.begin(), displacement.begin(), std::minus());
  values["way"] = norm(displacement);
}

/// Numbers of a result's last frame, and of the summary for a packing.
json result_values(const std::string& path) {
  const hdf5::Handle file = hdf5::load(path);
  const hsize_t last = hdf5::shape(file, "particles/conductors/position/value").at(0) - 1;
  json values;
  for (const char* name : {"energy",
                           "charge_held",
                           "charge_fed",
                           "charge_drained",
                           "field_solves",
                           "iterations",
                           "connected",
                           "endpoints",
                           "branch_points",
                           "energy_by_supplies",
                           "heat_series_resistors",
                           "heat_contacts",
                           "heat_sparks",
                           "heat_drag",
                           "kinetic_energy",
                           "contact_energy",
                           "potential_energy",
                           "dissipated_energy",
                           "exchanged_energy",
                           "collisions"})
    if (const std::string value = fmt::format("observables/{}/value", name); hdf5::exists(file, value))
      values[name] = hdf5::get_rows<double>(file, value, last, 1).at(0);
  for (const char* name :
       {"loops", "iterations", "evaluations", "energy", "contacts", "rattlers", "smallest_q", "pressure"})
    if (hdf5::exists(file, std::string("summary/") + name))
      values[name] = hdf5::get<double>(file, std::string("summary/") + name).at(0);
  if (hdf5::exists(file, "network/contacts")) values["contacts"] = hdf5::shape(file, "network/contacts").at(0);
  add_particles(file, last, values);
  return values;
}

/// Numbers printed by `solve --json`.
json solution_values(const json& solution) {
  std::vector<double> charge, potential, force;
  for (const json& conductor : solution.at("conductors")) {
    charge.push_back(conductor.at("charge"));
    potential.push_back(conductor.at("potential"));
    for (const double component : conductor.at("force")) force.push_back(component);
  }
  return {{"energy", solution.at("energy")},
          {"iterations", solution.at("iterations")},
          {"charge", norm(charge)},
          {"potential", norm(potential)},
          {"force", norm(force)}};
}

/// Numbers that the built program computes for a row.
json recomputed(const json& row) {
  const std::string scene = row.at("scene");
  std::vector<Setting> settings;
  for (const auto& [key, value] : row.at("settings").items()) settings.push_back({key, value});
  const Folder folder;
  folder.write("scene.toml", with_settings(text_of(source / "scenes" / scene), scene, settings));
  const bool solves = row.at("command") == "solve";
  const Ended ended =
      run_program(folder, solves ? "solve scene.toml --json" : "run scene.toml --out result.h5 --quiet");
  INFO(ended.err);
  REQUIRE(ended.status == 0);
  return solves ? solution_values(json::parse(ended.out)) : result_values(folder / "result.h5");
}

}  // namespace

TEST_CASE("scenes/: each scene has a row in shipped_scenes.json") {
  std::set<std::string> rerun;
  const json rows = table()["rows"];
  for (const json& row : rows) rerun.insert(row.at("scene").get<std::string>());
  for (const fs::directory_entry& entry : fs::directory_iterator(source / "scenes"))
    if (entry.path().extension() == ".toml") {
      const std::string scene = entry.path().filename();
      INFO(scene, " has no row in ", table_path.string());
      CHECK(rerun.contains(scene));
    }
}

TEST_CASE("scenes/: a shortened run of each gives the stored numbers") {
  const json rows = table()["rows"];
  for (const json& row : rows) {
    const std::string scene = row.at("scene");
    SUBCASE(scene.c_str()) {
      const json& values = row.at("values");
      const json found = recomputed(row);
      CHECK(found.size() == values.size());
      for (const auto& [name, value] : values.items()) {
        CAPTURE(name);
        REQUIRE(found.contains(name));
        const double stored = value, now = found[name];
        CHECK_MESSAGE(std::abs(now - stored) <= allowed(name, values, row.at("tolerance")),
                      fmt::format("{}: {} is {:.17g} and was {:.17g}", scene, name, now, stored));
      }
    }
  }
}

TEST_CASE("scenes/: the stored numbers are updated (skipped unless requested)" * doctest::skip()) {
  json written = table();
  for (json& row : written["rows"]) row["values"] = recomputed(row);
  std::ofstream(table_path) << written.dump(2) << '\n';
}

}  // namespace shipped_scenes_test
