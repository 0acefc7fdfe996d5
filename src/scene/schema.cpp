#include "src/scene/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "src/scene/effect_kind.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {

namespace {

/// Effects with a former name.
constexpr std::pair<std::string_view, const char*> former_paths[] = {{"current_injection", "effects.current_source"},
                                                                     {"soft_repulsion", "effects.contact_potential"}};

std::string former_path(const std::string& effect) {
  const auto found =
      std::ranges::find(former_paths, std::string_view(effect), [](const auto& entry) { return entry.first; });
  return found == std::end(former_paths) ? "" : found->second;
}

Table table_of(const EffectKind& kind) {
  return {.path = "effects." + kind.name,
          .help = kind.help,
          .open = [&kind](Draft& draft, int) { draft.scene.effects.add(kind, kind.options); },
          .keys = kind.keys,
          .old_path = former_path(kind.name)};
}

}  // namespace

Schema::Schema(const EffectKinds& kinds) : tables_(tables_of_the_world()) {
  check_names(kinds);
  std::ranges::move(tables_of_bodies(), std::back_inserter(tables_));
  std::ranges::move(tables_of_grains(), std::back_inserter(tables_));
  tables_.push_back(
      {.path = "effects", .help = "Tables of the effects. A run contains an effect only if the scene has its table."});
  for (const EffectKind* kind : kinds) tables_.push_back(table_of(*kind));
  std::ranges::move(tables_of_the_computation(), std::back_inserter(tables_));
}

const Table* Schema::find_table(std::string_view path) const {
  const auto found = std::ranges::find(tables_, path, &Table::path);
  return found == tables_.end() ? nullptr : &*found;
}

std::vector<Key> joined(std::initializer_list<std::vector<Key>> lists) {
  std::vector<Key> all;
  for (const std::vector<Key>& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

const Key* find_key(const Table& table, std::string_view name) {
  const auto found = std::ranges::find(table.keys, name, &Key::name);
  return found == table.keys.end() ? nullptr : &*found;
}

std::string path_in(const Table& table, std::string_view name) {
  return table.path.empty() ? std::string(name) : fmt::format("{}.{}", table.path, name);
}

std::vector<std::string> Schema::known_paths() const {
  std::vector<std::string> known;
  for (const Table& table : tables_) {
    if (!table.path.empty()) known.push_back(table.path);
    for (const Key& key : table.keys) known.push_back(path_in(table, key.name));
  }
  return known;
}

int Draft::line(const std::string& path) const {
  const auto is_of_absent_effect = [&] {
    const std::string effects = "effects.";
    return path.starts_with(effects) && !known.contains(path.substr(0, path.find('.', effects.size())));
  };
  if (!known.empty() && !known.contains(path) && !is_of_absent_effect())
    throw std::logic_error("no table or key of scenes has the path " + path);
  const auto found = lines.find(path);
  return found == lines.end() ? 0 : found->second;
}

Draft Schema::blank_draft() const {
  Draft draft;
  for (const std::string& path : known_paths()) draft.known.insert(path);
  for (const Table& table : tables_) table.open(draft, 0);
  return draft;
}

bool Range::contains(double value) const {
  return std::isfinite(value) && (low_itself ? value >= low : value > low) &&
         (high_itself ? value <= high : value < high);
}

bool Range::allows_size_of(double value) const {
  const double size = std::abs(value);
  const double least = low > 0 ? std::min(low, smallest_size) : smallest_size;
  const double most = std::isfinite(high) ? std::max(high, largest_size) : largest_size;
  return size == 0 || (size >= least && size <= most);
}

std::string Range::text() const {
  std::vector<std::string> ends;
  if (std::isfinite(low)) ends.push_back(fmt::format("{} {:.10g}", low_itself ? "at least" : "greater than", low));
  if (std::isfinite(high)) ends.push_back(fmt::format("{} {:.10g}", high_itself ? "at most" : "less than", high));
  return fmt::format("{}", fmt::join(ends, " and "));
}

std::vector<std::string> Key::choices() const {
  const auto* choice = std::get_if<AtChoice>(&target);
  return choice ? choice->names : texts;
}

std::string Key::allowed() const {
  if (const auto all = choices(); !all.empty()) return fmt::format("one of \"{}\"", fmt::join(all, "\", \""));
  std::string text = std::visit(Overloaded{[](const AtChoice&) { return std::string(type_name(std::string())); },
                                           []<class T>(At<T>) { return std::string(type_name(T{})); }},
                                target);
  if (!unit.empty()) text += " in " + unit;
  const std::string limits = range.text();
  return limits.empty() ? text : text + ", " + limits;
}

std::string Key::fallback(Draft& untouched) const {
  if (required) return "required";
  if (!shapes.empty()) return fmt::format("required for {}", fmt::join(shapes, ", "));
  if (!computed_default.empty() && optional_shapes.empty()) return "default: " + computed_default;
  const std::string value = std::visit(Overloaded{[&](const AtChoice& at) { return show(at.name(untouched)); },
                                                  [&]<class T>(At<T> at) { return show(*at(untouched)); }},
                                       target);
  return "default: " + value +
         (optional_shapes.empty() ? "" : fmt::format(" for {}", fmt::join(optional_shapes, ", ")));
}

std::string Table::header() const {
  if (path.empty()) return "(top of the file)";
  return kind == Kind::repeated ? "[[" + path + "]]" : "[" + path + "]";
}

}  // namespace lichtenberg
