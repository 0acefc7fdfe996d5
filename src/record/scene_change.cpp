#include "src/record/scene_change.hpp"

#include <toml++/toml.h>

#include <set>

#include "src/effects/effects.hpp"
#include "src/scene/document.hpp"
#include "src/scene/old_names.hpp"
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace {

std::set<std::string> keys_of(const toml::table& a, const toml::table& b) {
  std::set<std::string> keys;
  for (const toml::table* table : {&a, &b})
    for (const auto& [key, value] : *table) keys.emplace(key.str());
  return keys;
}

/// Compares two values in tables, because toml++ compares only tables.
bool equal(const toml::node& a, const toml::node& b) {
  toml::table with_a, with_b;
  with_a.insert("value", a);
  with_b.insert("value", b);
  return with_a == with_b;
}

std::string first_difference(const toml::table& a, const toml::table& b) {
  for (const std::string& key : keys_of(a, b)) {
    const toml::node *left = a.get(key), *right = b.get(key);
    if (left == nullptr || right == nullptr) return key;
    if (left->is_table() && right->is_table()) {
      const std::string inside = first_difference(*left->as_table(), *right->as_table());
      if (!inside.empty()) return key + "." + inside;
    } else if (!equal(*left, *right)) {
      return key;
    }
  }
  return "";
}

toml::table without_ignored_keys(const std::string& text, const std::string& path) {
  toml::table table = parse_document(text, path);
  replace_old_names(table, Schema(effects::all_kinds()), "");
  table.erase("stop");
  table.erase("output");
  table.erase("network");
  if (toml::table* minimize = table["minimize"].as_table()) {
    for (const char* key : {"max_iterations", "force_tolerance", "threads"}) minimize->erase(key);
    if (minimize->empty()) table.erase("minimize");
  }
  return table;
}

}  // namespace

std::string first_change(const std::string& before, const std::string& now, const std::string& path_before) {
  return first_difference(without_ignored_keys(before, path_before), without_ignored_keys(now, "scene"));
}

}  // namespace lichtenberg
