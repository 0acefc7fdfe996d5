#include "src/scene/old_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/scene/schema.hpp"

namespace lichtenberg {

namespace {

/// Returns the former path of a table if no other table has it, as an added effect may; empty otherwise.
std::string former_path(const Table& table, const Schema& schema) {
  return schema.find_table(table.old_path) == nullptr ? table.old_path : "";
}

/// Returns the parts of a path before and after its last dot.
std::pair<std::string, std::string> split_path(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos) return {"", path};
  return {path.substr(0, dot), path.substr(dot + 1)};
}

/// Returns the tables of the document at that path: none, one, or the elements of a repeated table.
std::vector<toml::table*> tables_at(toml::table& document, const std::string& path) {
  if (path.empty()) return {&document};
  std::vector<toml::table*> tables;
  const toml::node_view node = document.at_path(path);
  if (toml::table* table = node.as_table()) tables.push_back(table);
  if (toml::array* elements = node.as_array())
    for (toml::node& element : *elements)
      if (toml::table* table = element.as_table()) tables.push_back(table);
  return tables;
}

/// Gives the entries `old_path` of the document the name of `new_path`, in the same table. Adds a warning for the first
/// of them.
void replace(toml::table& document, const std::string& file, const std::string& old_path, const std::string& new_path,
             std::vector<std::string>& warnings) {
  const auto [table_path, new_name] = split_path(new_path);
  const std::string old_name = split_path(old_path).second;
  bool is_first = true;
  for (toml::table* table : tables_at(document, table_path)) {
    const auto entry = table->find(old_name);
    if (entry == table->end()) continue;
    const int line = static_cast<int>(entry->first.source().begin.line);
    if (table->contains(new_name))
      refuse(file, line, fmt::format("{} is an old name of {}, which is given too: leave one out", old_path, new_path));
    if (std::exchange(is_first, false))
      warnings.push_back(location_prefix(file, line) + old_name_warning(old_path, new_path));
    toml::key key(new_name, toml::source_region(entry->first.source()));
    table->insert(std::move(key), std::move(entry->second));
    table->erase(old_name);
  }
}

}  // namespace

std::string old_name_warning(const std::string& old_path, const std::string& new_path) {
  return fmt::format("{} is an old name: it is called {} now", old_path, new_path);
}

std::vector<std::string> replace_old_names(toml::table& document, const Schema& schema, const std::string& path) {
  std::vector<std::string> warnings;
  for (const Table& table : schema.tables())
    if (const std::string old_path = former_path(table, schema); !old_path.empty())
      replace(document, path, old_path, table.path, warnings);
  for (const Table& table : schema.tables())
    for (const Key& key : table.keys)
      if (!key.old_name.empty())
        replace(document, path, path_in(table, key.old_name), path_in(table, key.name), warnings);
  return warnings;
}

std::string without_old_names(const std::string& path, const Schema& schema) {
  std::string current = path;
  for (const Table& table : schema.tables()) {
    const std::string old = former_path(table, schema);
    if (old.empty() || !current.starts_with(old)) continue;
    if (current.size() == old.size() || current[old.size()] == '.' || current[old.size()] == '[') {
      current.replace(0, old.size(), table.path);
      break;
    }
  }
  const auto [table_path, name] = split_path(current);
  const Table* table = schema.find_table(table_path.substr(0, table_path.find('[')));
  if (table == nullptr) return current;
  const auto key = std::ranges::find(table->keys, name, &Key::old_name);
  if (name.empty() || key == table->keys.end()) return current;
  return current.replace(current.size() - name.size(), name.size(), key->name);
}

}  // namespace lichtenberg
