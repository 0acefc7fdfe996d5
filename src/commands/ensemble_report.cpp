#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string_view>

#include "src/commands/ensemble.hpp"
#include "src/version.hpp"

namespace lichtenberg::ensemble {
namespace {

constexpr const char* conductors_key = "population.count";

/// The interval with two digits, and the value to the same place; both small in units of a power of ten.
std::string shown(const analysis::Estimate& estimate) {
  const double half_width = estimate.half_width.value_or(0);
  if (half_width == 0) return fmt::format("{:.4g}{}", estimate.value, estimate.half_width ? " ± 0" : "");
  if (const double largest = std::max(std::abs(estimate.value), half_width); largest < 1e-3) {
    const double power = std::floor(std::log10(largest)), unit = std::pow(10, power);
    return fmt::format("({})e{:g}", shown({.value = estimate.value / unit, .half_width = half_width / unit}), power);
  }
  const int decimals = std::max(0, 1 - static_cast<int>(std::floor(std::log10(half_width))));
  return fmt::format("{:.{}f} ± {:.{}f}", estimate.value, decimals, half_width, decimals);
}

std::vector<Setting> without(std::vector<Setting> settings, const std::vector<std::string>& keys) {
  std::erase_if(settings, [&](const Setting& s) { return std::ranges::find(keys, s.key) != keys.end(); });
  return settings;
}

bool same(const std::vector<Setting>& a, const std::vector<Setting>& b) {
  return std::ranges::equal(a, b,
                            [](const Setting& x, const Setting& y) { return x.key == y.key && x.value == y.value; });
}

/// Finished members that agree in all settings but those of `keys`, in the order of their first.
std::vector<std::vector<const Member*>> groups_apart_from(const std::vector<std::string>& keys,
                                                          const std::vector<Member>& members) {
  std::vector<std::vector<const Member*>> groups;
  for (const Member& member : members) {
    if (member.state != MemberState::finished) continue;
    const auto alike = [&](const auto& group) {
      return same(without(group.front()->settings, keys), without(member.settings, keys));
    };
    const auto group = std::ranges::find_if(groups, alike);
    if (group == groups.end())
      groups.push_back({&member});
    else
      group->push_back(&member);
  }
  return groups;
}

std::vector<double> values_of(const std::vector<const Member*>& members, const std::string& quantity) {
  std::vector<double> values;
  for (const Member* member : members)
    if (const auto found = member->quantities.find(quantity);
        found != member->quantities.end() && std::isfinite(found->second))
      values.push_back(found->second);
  return values;
}

std::map<std::string, analysis::Estimate> means_of(const std::vector<const Member*>& members) {
  std::map<std::string, analysis::Estimate> means;
  for (const auto& [quantity, value] : members.front()->quantities)
    if (const std::vector<double> values = values_of(members, quantity); values.size() == members.size())
      means[quantity] = analysis::mean(values);
  return means;
}

struct Column {
  const char *quantity, *heading;
};
constexpr std::array course = {Column{"connected_fraction", "connected"},
                               Column{"endpoint_fraction", "endpoints f1"},
                               Column{"branch_fraction", "branch points B"},
                               Column{"loops", "loops"},
                               Column{"time", "time (s)"},
                               Column{"field_solves", "field solves"},
                               Column{"seconds", "wall time (s)"}};
constexpr std::array topology = {
    Column{"degree_fraction_2", "f2"},           Column{"degree_fraction_3", "f3"},
    Column{"degree_fraction_4", "f4"},           Column{"strahler_fraction_1", "Strahler 1"},
    Column{"strahler_fraction_2", "Strahler 2"}, Column{"strahler_fraction_3", "Strahler 3"}};

constexpr std::array gas = {Column{"temperature", "T with flow"},  Column{"local_temperature", "T"},
                            Column{"mean_square_charge", "<q^2>"}, Column{"clusters", "clusters"},
                            Column{"largest_cluster", "largest"},  Column{"mean_aggregate", "mean of 2 and more"}};
constexpr std::array gas_events = {Column{"dissipated_energy", "dissipated"},
                                   Column{"energy_error", "energy off by"},
                                   Column{"collisions", "collisions"},
                                   Column{"transfers", "transfers of charge"},
                                   Column{"largest_overlap", "largest overlap"},
                                   Column{"time", "time (t0)"},
                                   Column{"seconds", "wall time (s)"}};

/// A count that D holds to be proportional to the number of conductors.
struct Law {
  std::string_view quantity, name, source;
};
constexpr std::array laws = {Law{"endpoints", "endpoints", "D 7.11"}, Law{"branch_points", "branch points", "D 7.12"},
                             Law{"strahler_1", "Strahler 1", "D 7.18"}, Law{"strahler_2", "Strahler 2", "D 7.18"},
                             Law{"strahler_3", "Strahler 3", "D 7.18"}};

using Cells = std::vector<std::vector<std::string>>;

/// Characters on the screen of UTF-8 text.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

void print_table(const Cells& rows) {
  if (rows.empty()) return;
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width(row[k]));
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k)
      line += row[k] + std::string(k + 1 < row.size() ? widths[k] - width(row[k]) + 2 : 0, ' ');
    fmt::print("{}\n", line);
  }
  fmt::print("\n");
}

/// Those of the columns that there is something to put into; none: no rows.
Cells cells_of(const std::vector<Point>& points, std::span<const Column> columns) {
  std::vector<Column> present;
  for (const Column& column : columns)
    if (std::ranges::any_of(points, [&](const Point& p) { return p.quantities.contains(column.quantity); }))
      present.push_back(column);
  if (present.empty()) return {};
  Cells rows(1);
  for (const Setting& setting : points.front().settings) rows.front().push_back(setting.key);
  rows.front().push_back("runs");
  for (const Column& column : present) rows.front().push_back(column.heading);
  for (const auto& [settings, runs, quantities] : points) {
    std::vector<std::string>& row = rows.emplace_back();
    for (const Setting& setting : settings) row.push_back(setting.value);
    row.push_back(std::to_string(runs));
    for (const Column& column : present) {
      const auto found = quantities.find(column.quantity);
      row.push_back(found == quantities.end() ? "" : shown(found->second));
    }
  }
  return rows;
}

nlohmann::ordered_json to_json(const std::vector<Setting>& settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [key, value] : settings) {
    json[key] = nlohmann::ordered_json::parse(value, nullptr, false);  // numbers, texts and arrays are the same in TOML
    if (json[key].is_discarded()) json[key] = value;
  }
  return json;
}

nlohmann::ordered_json to_json(const analysis::Estimate& estimate) {
  nlohmann::ordered_json json{{"value", estimate.value}};
  if (estimate.half_width) json["half_width"] = *estimate.half_width;
  json["deviation"] = estimate.deviation;
  json["sample"] = estimate.sample;
  return json;
}

std::string to_text(MemberState state) {
  switch (state) {
    case MemberState::waiting:
      return "waiting";
    case MemberState::running:
      return "running";
    case MemberState::finished:
      return "finished";
    case MemberState::stopped:
      return "stopped";
    default:
      return "failed";
  }
}

}  // namespace

Summary summarize(const std::vector<Member>& members) {
  Summary summary;
  for (const auto& group : groups_apart_from({"seed"}, members))
    summary.points.push_back(
        {without(group.front()->settings, {"seed"}), static_cast<int>(group.size()), means_of(group)});
  for (const auto& group : groups_apart_from({"seed", conductors_key}, members)) {
    const std::vector<double> conductors = values_of(group, "conductors");
    if (std::set(conductors.begin(), conductors.end()).size() < 2) continue;
    for (const Law& law : laws) {
      const std::string quantity(law.quantity);
      if (const std::vector<double> counts = values_of(group, quantity); counts.size() == conductors.size())
        summary.proportions.push_back({without(group.front()->settings, {"seed", conductors_key}), quantity,
                                       analysis::slope(conductors, counts)});
    }
  }
  return summary;
}

void print(const Summary& summary) {
  if (summary.points.empty()) return;
  fmt::print("means over the runs of different seeds, with 95 % confidence intervals (Student's t)\n\n");
  const bool of_grains = summary.points.front().quantities.contains("dissipated_energy") &&
                         summary.points.front().quantities.contains("collisions");
  if (of_grains) {
    fmt::print("at the end, in units of the scene's scales; T relative to the flow in cells, and with it\n\n");
    print_table(cells_of(summary.points, gas));
    print_table(cells_of(summary.points, gas_events));
  } else {
    print_table(cells_of(summary.points, course));
    print_table(cells_of(summary.points, topology));
  }
  if (!summary.proportions.empty()) fmt::print("least squares through the origin over all runs, N conductors\n\n");
  for (const auto& [settings, quantity, slope] : summary.proportions) {
    std::string with;
    for (const Setting& setting : settings) with += fmt::format("  {} = {}", setting.key, setting.value);
    const Law& law = *std::ranges::find(laws, quantity, &Law::quantity);
    fmt::print("{:<14} = ({}) N  ({}){}\n", law.name, shown(slope), law.source, with);
  }
}

nlohmann::ordered_json to_json(const std::string& scene_path, const std::vector<Member>& members,
                               const Summary& summary) {
  using Json = nlohmann::ordered_json;
  Json json{{"scene", scene_path},
            {"intervals", "95 %, Student's t"},
            {"members", Json::array()},
            {"points", Json::array()},
            {"proportions", Json::array()}};
  json["version"] = lichtenberg_version().number;  // of the summary; each result file has that of its run
  json["commit"] = lichtenberg_version().commit;
  for (const Member& member : members) {
    Json entry{{"name", member.name}, {"settings", to_json(member.settings)}, {"state", to_text(member.state)}};
    if (!member.sentence.empty()) entry["sentence"] = member.sentence;
    if (!member.quantities.empty()) entry["quantities"] = member.quantities;
    if (!member.warnings.empty()) entry["warnings"] = member.warnings;
    json["members"].push_back(std::move(entry));
  }
  for (const auto& [settings, runs, quantities] : summary.points) {
    Json entry{{"settings", to_json(settings)}, {"runs", runs}, {"quantities", Json::object()}};
    for (const auto& [quantity, estimate] : quantities) entry["quantities"][quantity] = to_json(estimate);
    json["points"].push_back(std::move(entry));
  }
  for (const auto& [settings, quantity, slope] : summary.proportions)
    json["proportions"].push_back({{"settings", to_json(settings)}, {"quantity", quantity}, {"slope", to_json(slope)}});
  return json;
}

}  // namespace lichtenberg::ensemble
