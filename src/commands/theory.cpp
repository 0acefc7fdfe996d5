#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/device.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/streams.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {
namespace {

struct TheoryArguments {
  std::string name, result, scene, csv, picture;
  JsonTarget json;
  std::vector<std::string> settings;
  TheoryOptions options;
  bool plot = false, overwrite = false;
};

std::optional<GasParameters> gas_of(const TheoryArguments& request, const TheoryKind& kind) {
  if (!request.result.empty()) {
    const Result result(request.result);
    GasParameters gas = gas_parameters(result.scene());
    gas.source = request.result;
    return gas;
  }
  if (!request.scene.empty()) return gas_parameters(read_scene_for(request.scene, "", request.settings));
  return kind.usual_gas ? std::optional(kind.usual_gas()) : std::nullopt;
}

/// Throws Failure if a table has no columns, columns of different lengths, or a panel with a column that it lacks.
void check_tables(const TheoryAnswer& answer, const TheoryKind& kind) {
  const auto refuse = [&](const TheoryTable& table, const std::string& fault) {
    throw Failure(fmt::format("theory {}: the table {} {}", kind.name, table.name, fault));
  };
  for (const TheoryTable& table : answer.tables) {
    if (table.columns.empty()) refuse(table, "has no columns");
    for (const TheoryColumn& column : table.columns)
      if (column.values.size() != table.columns[0].values.size())
        refuse(table, fmt::format("has {} values of {} and {} of {}", column.values.size(), column.name,
                                  table.columns[0].values.size(), table.columns[0].name));
    for (const TheoryTable::Panel& panel : table.panels)
      for (const std::string& name : panel.columns)
        if (std::ranges::find(table.columns, name, &TheoryColumn::name) == table.columns.end())
          refuse(table, fmt::format("draws the column {}, which it lacks", name));
  }
}

TheoryAnswer answer_to(const TheoryArguments& request, const TheoryKind& kind) {
  const std::optional<GasParameters> gas = gas_of(request, kind);
  std::optional<GasTimeSeries> time_series;
  if (!request.result.empty()) time_series.emplace(request.result, gas->warm_up);
  TheoryAnswer answer = kind.answer({.gas = gas,
                                     .gas_is_given = !request.scene.empty() || !request.result.empty(),
                                     .run = time_series ? &*time_series : nullptr,
                                     .options = request.options});
  check_tables(answer, kind);
  return answer;
}

/// Returns the origin of the parameters; empty for a theory without a gas.
std::string source_of(const TheoryArguments& request, const TheoryKind& kind) {
  if (!request.result.empty()) return request.result;
  if (!request.scene.empty()) return request.scene;
  return kind.usual_gas ? "the source's own parameters (--scene for others)" : "";
}

std::string heading(const TheoryColumn& column) {
  return column.unit == "1" ? column.name : fmt::format("{} ({})", column.name, column.unit);
}

std::string cell(double value, int digits = 6) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "-";
}

/// Prints the columns from `begin` that fit on a line after the first column. Returns the index of the next column.
std::size_t print_columns(const TheoryTable& table, std::size_t begin, std::size_t every) {
  constexpr std::size_t line = 120, narrowest = 12;
  const auto width = [&](std::size_t k) {
    return 2 + std::max({narrowest, table.columns[k].name.size(), table.columns[k].unit.size() + 2});
  };
  std::vector<std::size_t> shown = {0};
  std::size_t filled = width(0), next = begin;
  for (; next < table.columns.size() && (shown.size() == 1 || filled + width(next) <= line); ++next)
    shown.push_back(next), filled += width(next);
  const auto row = [&](auto text) {
    for (const std::size_t k : shown) fmt::print("{:>{}}", text(table.columns[k]), width(k));
    fmt::print("\n");
  };
  fmt::print("\n");
  row([](const TheoryColumn& column) { return column.name; });
  row([](const TheoryColumn& column) { return column.unit == "1" ? "" : "(" + column.unit + ")"; });
  for (std::size_t n = 0; n < table.columns[0].values.size(); n += every)
    row([&](const TheoryColumn& column) { return cell(column.values[n]); });
  return next;
}

/// Returns the column at x by linear interpolation of logarithms; NaN outside of the table.
double value_at(const TheoryTable& table, const TheoryColumn& column, double x) {
  const std::vector<double>& all = table.columns[0].values;
  const auto after = std::ranges::lower_bound(all, x) - all.begin();
  if (after == 0 || after == static_cast<std::ptrdiff_t>(all.size())) return NAN;
  const double part = std::log(x / all[after - 1]) / std::log(all[after] / all[after - 1]);
  return std::exp((1 - part) * std::log(column.values[after - 1]) + part * std::log(column.values[after]));
}

/// Prints a run's values next to the expected ones, at instants on a logarithmic scale.
void print_found(const TheoryTable& table, const FoundSeries& found) {
  const auto column = std::ranges::find(table.columns, found.of, &TheoryColumn::name);
  const TheoryColumn& x = table.columns[0];
  fmt::print("\n{}\n{:>14}{:>14}{:>26}{:>10}\n", found.label, x.name, "found", found.of, "ratio");
  double next = 0;
  for (std::size_t k = 0; k < found.x.size(); ++k) {
    if (found.x[k] < next && k + 1 < found.x.size()) continue;
    next = 2 * found.x[k];
    const double expected = value_at(table, *column, found.x[k]);
    fmt::print("{:>14}{:>14}{:>26}{:>10}\n", cell(found.x[k]), cell(found.y[k]), cell(expected),
               std::isfinite(found.y[k] / expected) ? fmt::format("{:.4g}", found.y[k] / expected) : "-");
  }
}

/// Prints evenly selected rows, in blocks of as many columns as fit on a line.
void print_table(const TheoryTable& table) {
  constexpr std::size_t most = 25;
  const std::size_t rows = table.columns[0].values.size(), every = (rows + most - 1) / most;
  fmt::print("\n{}{}\n", table.title, every > 1 ? fmt::format("; one row of {} of all {}", every, rows) : "");
  for (std::size_t next = 1; next < table.columns.size();) next = print_columns(table, next, every);
  for (const FoundSeries& found : table.found) print_found(table, found);
}

void print_answer(const TheoryAnswer& answer, const std::string& source) {
  fmt::print("{}\n{}\n", answer.title, source.empty() ? "" : "of " + printable(source) + "\n");
  for (const TheoryFigure& figure : answer.figures)
    fmt::print("  {:<28}{:>14}{:<10}{}\n", figure.name, std::isinf(figure.value) ? "infinite" : cell(figure.value, 8),
               figure.unit == "1" ? "" : " " + figure.unit, figure.meaning);
  for (const TheoryTable& table : answer.tables) print_table(table);
}

/// Converts a table. Infinity and NaN are written as null.
nlohmann::ordered_json json_of(const TheoryTable& table) {
  nlohmann::ordered_json json{{"name", table.name}, {"title", table.title}, {"logarithmic", table.logarithmic}};
  for (const TheoryColumn& column : table.columns)
    json["columns"][column.name] = {{"unit", column.unit}, {"label", column.label}, {"values", column.values}};
  json["panels"] = nlohmann::ordered_json::array();
  for (const TheoryTable::Panel& panel : table.panels)
    json["panels"].push_back({{"label", panel.label}, {"logarithmic", panel.logarithmic}, {"columns", panel.columns}});
  json["found"] = nlohmann::ordered_json::array();
  for (const FoundSeries& found : table.found)
    json["found"].push_back({{"of", found.of}, {"label", found.label}, {"x", found.x}, {"y", found.y}});
  return json;
}

/// Converts maps with four digits, which suffices for pictures. The option --field stores the full precision.
nlohmann::ordered_json json_of(const TheoryMaps& maps) {
  nlohmann::ordered_json json{{"title", maps.title}, {"cells", maps.cells}, {"length", maps.length}};
  for (const TheoryMaps::Map& map : maps.fields) {
    std::vector<double> values;
    for (const double value : map.values) values.push_back(std::stod(fmt::format("{:.4g}", value)));
    json["fields"].push_back(
        {{"name", map.name}, {"label", map.label}, {"logarithmic", map.logarithmic}, {"values", values}});
  }
  return json;
}

nlohmann::ordered_json json_of(const TheoryAnswer& answer, const std::string& source) {
  nlohmann::ordered_json json{{"theory", answer.name}, {"title", answer.title}, {"of", source}};
  json["figures"] = nlohmann::ordered_json::array();
  for (const TheoryFigure& figure : answer.figures)
    json["figures"].push_back(
        {{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}, {"meaning", figure.meaning}});
  json["tables"] = nlohmann::ordered_json::array();
  for (const TheoryTable& table : answer.tables) json["tables"].push_back(json_of(table));
  for (const TheoryMaps& maps : answer.maps) json["maps"].push_back(json_of(maps));
  return json;
}

/// Writes the tables, separated by empty lines. Non-finite numbers become empty cells.
void write_csv(const std::string& path, const TheoryAnswer& answer) {
  std::string text;
  for (const TheoryTable& table : answer.tables) {
    if (!text.empty()) text += "\n";
    for (const TheoryColumn& column : table.columns)
      text += (&column == table.columns.data() ? "" : ",") + heading(column);
    text += "\n";
    for (std::size_t row = 0; row < table.columns[0].values.size(); ++row) {
      for (const TheoryColumn& column : table.columns) {
        if (&column != table.columns.data()) text += ",";
        if (std::isfinite(column.values[row])) text += fmt::format("{:.17g}", column.values[row]);
      }
      text += "\n";
    }
  }
  write_atomically(path, std::as_bytes(std::span(text)));
}

bool draws(const TheoryArguments& request) { return request.plot || !request.picture.empty(); }

std::string theory_picture(const TheoryArguments& request) {
  if (!request.picture.empty()) return request.picture;
  const std::string& source_file = request.result.empty() ? request.scene : request.result;
  const std::string stem = source_file.empty() ? "theory" : std::filesystem::path(source_file).stem().string();
  return fmt::format("{}-{}.png", stem, request.name);
}

/// Returns the options that only some theories have, and whether each is given.
std::array<std::pair<std::string, bool>, 10> special_options(const TheoryOptions& given) {
  return {{{"--restitution", given.restitution.has_value()},
           {"--charge-number", given.charge_number.has_value()},
           {"--cells", given.cells.has_value()},
           {"--seed", given.seed.has_value()},
           {"--space", given.space},
           {"--separated", given.separated},
           {"--field", !given.field.empty()},
           {"--kernel", !given.kernel.empty()},
           {"--repulsion", given.repulsion.has_value()},
           {"--until", given.until.has_value()}}};
}

/// Throws Failure for two theories of one name, and for an option that TheoryOptions lacks.
void check_kinds(const std::vector<TheoryKind>& kinds) {
  const auto options = special_options({});
  for (const TheoryKind& kind : kinds) {
    if (std::ranges::count(kinds, kind.name, &TheoryKind::name) > 1)
      throw Failure(fmt::format("two theories have the name {}", kind.name));
    for (const std::string& option : kind.options)
      if (std::ranges::find(options, option, &std::pair<std::string, bool>::first) == options.end())
        throw Failure(fmt::format("theory {}: {} is no option of theories", kind.name, option));
  }
}

/// Throws InputError for the first given option that the theory does not have.
void check_options(const TheoryOptions& given, const TheoryKind& kind, const std::vector<TheoryKind>& kinds) {
  const auto takes = [](const TheoryKind& k, const std::string& option) {
    return std::ranges::find(k.options, option) != k.options.end();
  };
  for (const auto& [option, is_given] : special_options(given)) {
    if (!is_given || takes(kind, option)) continue;
    std::vector<std::string> others;
    for (const TheoryKind& other : kinds)
      if (takes(other, option)) others.push_back("theory " + other.name);
    throw InputError(
        fmt::format("option {} is for {}, not for theory {}", option, fmt::join(others, " and "), kind.name));
  }
  if (given.seed && *given.seed < 0)
    throw InputError(fmt::format("--seed {} is not allowed: it must be 0 or more", *given.seed));
}

void check_theory(const TheoryArguments& request) {
  if (!request.settings.empty() && request.scene.empty())
    throw InputError("--set changes a key of the scene that --scene names: it needs --scene");
  if (draws(request)) check_picture("--out", theory_picture(request));
  const std::vector<std::string> written{request.json.file(), request.csv, request.options.field,
                                         draws(request) ? theory_picture(request) : ""};
  check_overwrite(request.overwrite, written, "--plot, --out, --csv, --field or --json=FILE");
  check_outputs(written, {request.result, request.scene}, request.overwrite);
}

void print_theory(const TheoryArguments& request, const std::vector<TheoryKind>& kinds) {
  const TheoryKind& kind = *std::ranges::find(kinds, request.name, &TheoryKind::name);
  check_options(request.options, kind, kinds);
  check_theory(request);
  if (!request.result.empty()) read_in_child({request.result});
  const TheoryAnswer answer = answer_to(request, kind);
  const std::string source = source_of(request, kind);
  if (!request.json.printed()) print_answer(answer, source);
  if (!request.json.word.empty()) request.json.put(json_of(answer, source), 1);
  if (!request.csv.empty()) write_csv(request.csv, answer);
  if (draws(request))
    draw_json("theory.draw_file", json_of(answer, source), theory_picture(request), request.json.printed());
}

}  // namespace

Command theory_command(const std::vector<TheoryKind>& kinds) {
  check_kinds(kinds);
  auto request = std::make_shared<TheoryArguments>();
  std::vector<std::string> names;
  for (const TheoryKind& kind : kinds) names.push_back(kind.name);
  return {"theory",
          "Prints predictions of theories of a gas of grains: cooling, charging, merging, growth, stability, flow",
          {{"NAME", &request->name, "name of the theory", {.required = true, .allowed = names}},
           {"RESULT", &request->result,
            "result file of a run (.h5): its scene is used and its values are shown for comparison, also its clusters "
            "after `analyse`"},
           {"--scene",
            &request->scene,
            "scene file (.toml) with the gas (default: the source's gas)",
            {.excluded = "RESULT"}},
           set_argument(request->settings),
           {"--plot", &request->plot, "draw the tables into a picture with the default name of --out"},
           {"--out", &request->picture,
            "picture to write: .png, .pdf or .svg (default with --plot: SCENE, RESULT or theory, with -NAME.png)"},
           json_argument(request->json, "all rows"),
           {"--csv", &request->csv, "CSV file to write, with all rows"},
           {"--restitution", &request->options.restitution,
            "restitution for stability and hydrodynamics instead of the gas's (default without a gas: .7)"},
           {"--charge-number", &request->options.charge_number,
            "R for stability and hydrodynamics instead of the gas's (default without a gas: .9)"},
           {"--cells", &request->options.cells, "cells of hydrodynamics along an edge (default: 32, in space 24)"},
           {"--space", &request->options.space, "hydrodynamics in space instead of a plane"},
           {"--separated", &request->options.separated,
            "hydrodynamics of initially separated charges of either sign (G A5.3)"},
           {"--seed", &request->options.seed, "seed of the initial noise of hydrodynamics (default: 1)"},
           {"--field", &request->options.field,
            "VTKHDF file to write, with the last fields of hydrodynamics, for ParaView"},
           {"--kernel", &request->options.kernel,
            "kernel for smoluchowski: brownian, power:MU,NU for (i^MU j^NU + i^NU j^MU)/2, or a CSV file with sizes in "
            "its first line and a row of values for each (default: those of the source)"},
           {"--repulsion", &request->options.repulsion,
            "energy of two equally charged grains in contact over the temperature, for --kernel (default: none)"},
           {"--until", &request->options.until, "last time for --kernel, in units of the kernel (default: 1000)"},
           overwrite_argument(request->overwrite)},
          [request, kinds] { print_theory(*request, kinds); }};
}

}  // namespace lichtenberg
