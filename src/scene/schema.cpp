#include "src/scene/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "src/scene/schema_tables.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {

const std::vector<Table>& schema() {
  static const std::vector<Table> all = {tables::top(),
                                         tables::domain(),
                                         tables::medium(),
                                         tables::material(),
                                         tables::electrode(),
                                         tables::wall(),
                                         tables::conductor(),
                                         tables::group(),
                                         tables::population(),
                                         tables::effects(),
                                         tables::floating_conductors(),
                                         tables::current_source(),
                                         tables::stokes_drag(),
                                         tables::hertz_contact(),
                                         tables::wall_contact(),
                                         tables::contact_discharge(),
                                         tables::leakage(),
                                         tables::contact_resistance(),
                                         tables::contact_potential(),
                                         tables::minimize(),
                                         tables::field(),
                                         tables::mechanics(),
                                         tables::network(),
                                         tables::output(),
                                         tables::stop()};
  return all;
}

const Table* find_table(std::string_view path) {
  const auto found = std::ranges::find(schema(), path, &Table::path);
  return found == schema().end() ? nullptr : &*found;
}

const Key* find_key(const Table& table, std::string_view name) {
  const auto found = std::ranges::find(table.keys, name, &Key::name);
  return found == table.keys.end() ? nullptr : &*found;
}

std::string path_in(const Table& table, std::string_view name) {
  return table.path.empty() ? std::string(name) : fmt::format("{}.{}", table.path, name);
}

std::vector<std::string> known_paths() {
  std::vector<std::string> known;
  for (const Table& table : schema()) {
    if (!table.path.empty()) known.push_back(table.path);
    for (const Key& key : table.keys) known.push_back(path_in(table, key.name));
  }
  return known;
}

Draft blank_draft() {
  Draft draft;
  for (const Table& table : schema()) table.open(draft, 0);
  return draft;
}

bool Range::contains(double value) const {
  return std::isfinite(value) && (low_itself ? value >= low : value > low) &&
         (high_itself ? value <= high : value < high);
}

std::string Range::text() const {
  std::vector<std::string> ends;
  if (std::isfinite(low)) ends.push_back(fmt::format("{} {:.10g}", low_itself ? "at least" : "greater than", low));
  if (std::isfinite(high)) ends.push_back(fmt::format("{} {:.10g}", high_itself ? "at most" : "less than", high));
  return fmt::format("{}", fmt::join(ends, " and "));
}

std::string Key::allowed() const {
  if (!choices.empty()) return fmt::format("one of \"{}\"", fmt::join(choices, "\", \""));
  std::string text = std::visit([]<class T>(At<T>) { return type_name(T{}); }, place);
  if (!unit.empty()) text += " in " + unit;
  const std::string limits = range.text();
  return limits.empty() ? text : text + ", " + limits;
}

std::string Key::fallback() const {
  if (required) return "required";
  if (!shapes.empty()) return fmt::format("required for {}", fmt::join(shapes, ", "));
  if (!computed_default.empty()) return "default: " + computed_default;
  Draft untouched = blank_draft();
  return "default: " + std::visit([&](auto at) { return show(*at(untouched)); }, place);
}

std::string Table::header() const {
  if (path.empty()) return "(top of the file)";
  return kind == Kind::repeated ? "[[" + path + "]]" : "[" + path + "]";
}

}  // namespace lichtenberg
