// Theory added from outside through headers alone: the mean free time of a gas.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "src/commands/command_line.hpp"
#include "src/commands/theory_kind.hpp"
#include "tests/folder.hpp"

namespace extend_theory {

using namespace lichtenberg;

namespace {

/// Mean time between collisions of a grain of diameter and mass 1 over temperature: 1 / (4 sqrt(pi) n sqrt(T)), for a
/// dilute gas of spheres.
TheoryAnswer mean_free_time(const TheoryRequest& request) {
  const GasParameters& gas = *request.gas;
  const std::vector<double> temperatures = logarithmic_range(1e-4, 10, 11);
  TheoryTable table{.name = "course", .title = "mean free time", .columns = {{"temperature", "1", "T", temperatures}}};
  table.columns.push_back({"free_time", "t0", "mean free time", {}});
  for (const double t : temperatures)
    table.columns[1].values.push_back(1 / (4 * std::sqrt(std::numbers::pi * t) * gas.density));
  return {"free-time", "Mean time between collisions", common_figures(gas), {table}};
}

int run_theory(const Folder& folder, const std::vector<std::string>& options) {
  std::vector<TheoryKind> kinds = theory_kinds();
  kinds.push_back({.name = "free-time", .answer = mean_free_time, .usual_gas = source_gas});
  std::vector<std::string> words{"theory", "free-time", "--json=" + (folder / "answer.json").string()};
  words.insert(words.end(), options.begin(), options.end());
  return run_command_line(words, {theory_command(kinds)});
}

}  // namespace

TEST_CASE("user-defined theory: the command theory runs it and checks options") {
  const Folder folder;
  REQUIRE(run_theory(folder, {}) == 0);
  const auto answer = nlohmann::json::parse(std::ifstream(folder / "answer.json"));
  CHECK(answer["theory"] == "free-time");
  const auto& columns = answer["tables"][0]["columns"];
  const auto temperature = columns["temperature"]["values"].get<std::vector<double>>(),
             time = columns["free_time"]["values"].get<std::vector<double>>();
  REQUIRE(time.size() == 11);
  // At a hundred times the temperature the collision frequency is ten times as large, within rounding of a logarithm
  // and a power.
  CHECK(temperature.back() / temperature.front() == doctest::Approx(1e5).epsilon(1e-12));
  CHECK(time.front() / time.back() == doctest::Approx(std::sqrt(1e5)).epsilon(1e-12));
  // The program's collision frequency, at the gas's temperature of 10, includes the contact value.
  const auto figure = [&](const std::string& name) {
    for (const auto& each : answer["figures"])
      if (each["name"] == name) return each["value"].get<double>();
    return 0.0;
  };
  CHECK(figure("contact_value") / time.back() == doctest::Approx(figure("collision_frequency")).epsilon(1e-12));
  CHECK(run_theory(folder, {"--cells", "16", "--overwrite"}) == 2);  // The theory does not take this option.
}

TEST_CASE("user-defined theory: faulty tables, names and options are refused") {
  const auto status_of = [](const TheoryKind& kind) {
    return run_command_line({"theory", kind.name}, {theory_command({kind})});
  };
  static TheoryTable table;
  const TheoryKind kind{.name = "faulty", .answer = [](const TheoryRequest&) {
                          return TheoryAnswer{"faulty", "Faulty", {}, {table}};
                        }};
  table = {.name = "course", .title = "course", .columns = {{"x", "1", "x", {1, 2}}, {"y", "1", "y", {3, 4}}}};
  CHECK(status_of(kind) == 0);
  table.panels = {{"y", true, {"z"}}};
  CHECK(status_of(kind) == 1);
  table.panels.clear();
  table.columns[1].values.pop_back();
  CHECK(status_of(kind) == 1);
  table.columns.clear();
  CHECK(status_of(kind) == 1);
  TheoryKind unknown = kind;
  unknown.options = {"--cell"};
  CHECK_THROWS_AS(theory_command({unknown}), Failure);
  CHECK_THROWS_AS(theory_command({kind, kind}), Failure);
}

}  // namespace extend_theory
