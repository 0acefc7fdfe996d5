#include "src/scene/vary.hpp"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <optional>
#include <sstream>

#include "solvers/error.hpp"
#include "src/scene/document.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/old_names.hpp"
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace {

/// The parts of a key's path: "electrode[1].radius" is the table "electrode", its element 1 and the key "radius".
struct KeyLocation {
  const Table* table;
  std::optional<std::size_t> index;
  std::string name;
};

/// Removes an index such as "[1]" from the end of a table's path and returns it.
std::optional<std::size_t> take_index(std::string& path) {
  const std::size_t open = path.find('[');
  if (open == std::string::npos || !path.ends_with(']')) return {};
  std::size_t index = 0;
  const char* end = path.data() + path.size() - 1;
  const auto [stopped, error] = std::from_chars(path.data() + open + 1, end, index);
  if (error != std::errc() || stopped != end) return {};
  path.resize(open);
  return index;
}

/// Describes the value that may be set for the key of that path; empty if there is no such key.
std::string settable_description(const Schema& schema, const std::string& path) {
  const std::size_t dot = path.rfind('.');
  const Table* table = schema.find_table(dot == std::string::npos ? "" : path.substr(0, dot));
  const Key* key = table ? find_key(*table, path.substr(dot + 1)) : nullptr;
  return key ? fmt::format("{} is a single value and is set as a whole: it must be {}", path, key->allowed()) : "";
}

KeyLocation locate_key(const Schema& schema, const std::string& key) {
  const std::size_t dot = key.rfind('.');
  std::string table_path = dot == std::string::npos ? "" : key.substr(0, dot);
  const std::string name = key.substr(dot + 1);  // npos + 1 is 0
  const std::optional<std::size_t> index = take_index(table_path);
  const Table* table = schema.find_table(table_path);
  if (schema.find_table(key) != nullptr)
    throw InputError(
        fmt::format("{0} is no key of a scene but a table: name a key of it (`lichtenberg help scene {0}`)", key));
  if (const std::string whole = settable_description(schema, table_path); !whole.empty())
    throw InputError(fmt::format("{} is no key of a scene, because {}", key, whole));
  if (table == nullptr || find_key(*table, name) == nullptr)
    throw InputError(fmt::format("{} is no key of a scene: the nearest known key is {}", key,
                                 nearest_path(key, schema.known_paths())));
  if (index && table->kind != Table::Kind::repeated)
    throw InputError(
        fmt::format("key {}: there is one table {} in a scene, so no index is allowed", key, table->header()));
  return {table, index, name};
}

/// Returns the table at a dotted path and creates it if it is missing. Null if the path contains a value that is no
/// table.
toml::table* open_table(toml::table& document, const std::string& path) {
  toml::table* table = &document;
  std::istringstream names(path);
  for (std::string name; table != nullptr && std::getline(names, name, '.');)
    table = table->insert(name, toml::table{}).first->second.as_table();
  return table;
}

/// Returns the element of a repeated table to which a key refers.
toml::table& element_of(toml::table& document, const KeyLocation& location, const std::string& key) {
  const std::string header = location.table->header();
  toml::array* elements = document[location.table->path].as_array();
  const std::size_t count = elements == nullptr ? 0 : elements->size();
  if (count == 0) throw InputError(fmt::format("key {}: the scene has no table {}", key, header));
  if (!location.index && count > 1)
    throw InputError(fmt::format("key {}: the scene has {} tables {}; say which, from {}[0] to {}[{}]", key, count,
                                 header, location.table->path, location.table->path, count - 1));
  const std::size_t index = location.index.value_or(0);
  if (index >= count)
    throw InputError(
        fmt::format("key {}: the scene has {} tables {}, and the first has the index 0", key, count, header));
  toml::table* element = (*elements)[index].as_table();
  if (element == nullptr) throw InputError(fmt::format("key {}: the scene's entries {} are no tables", key, header));
  return *element;
}

toml::table& table_of(toml::table& document, const KeyLocation& location, const std::string& key) {
  if (location.table->kind == Table::Kind::repeated) return element_of(document, location, key);
  const std::string& path = location.table->path;
  if (path.starts_with("effects.") && !document.at_path(path).is_table())
    throw InputError(
        fmt::format("key {}: the scene has no table {}, so the effect is not in it", key, location.table->header()));
  toml::table* table = open_table(document, path);
  if (table == nullptr) throw InputError(fmt::format("key {}: in the scene {} is no table", key, path));
  return *table;
}

/// Parses a number that is not valid TOML because digits around the point are missing: .5, -.5, 1.
std::optional<double> bare_number(const std::string& value) {
  double number = 0;
  const char* end = value.data() + value.size();
  const auto [stopped, error] = std::from_chars(value.data(), end, number);
  if (error != std::errc() || stopped != end || value.find('.') == std::string::npos) return {};
  return number;
}

}  // namespace

std::vector<std::string> listed_values(const std::string& list) {
  const auto refuse_it = [&] {
    throw InputError(
        fmt::format("`{}` is no list of values: they are written as in a scene file, with commas between "
                    "them and text in quotes, as in 0.4e-3,0.8e-3 or \"cvode\",\"euler\"",
                    list));
  };
  std::vector<std::string> values;
  try {
    const toml::table document = toml::parse("list = [" + list + "\n]");
    for (const toml::node& value : *document["list"].as_array()) values.push_back(shown(value));
    if (document.size() != 1) refuse_it();
  } catch (const toml::parse_error&) {
    refuse_it();
  }
  if (values.empty()) refuse_it();
  return values;
}

Setting setting_of(const std::string& written) {
  const std::size_t equals = written.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError(fmt::format(
        "the setting {} is not valid: it must be KEY=VALUE, as in effects.contact_discharge.contact_distance=0.4e-3",
        written));
  std::string key = written.substr(0, equals), value = written.substr(equals + 1);
  while (key.ends_with(' ')) key.pop_back();
  try {
    parse_document("value = " + value, key);
  } catch (const InputError&) {
    const std::optional<double> number = bare_number(value);
    value = number ? shown(toml::value<double>(*number)) : shown(toml::value<std::string>(value));
  }
  return {key, value};
}

void apply(const std::vector<Setting>& settings, const Schema& schema, toml::table& document) {
  std::map<std::string, std::string> written_as;
  for (const auto& [written, value] : settings) {
    const std::string key = without_old_names(written, schema);
    if (const auto [other, is_new] = written_as.emplace(key, written); !is_new)
      throw InputError(other->second == written
                           ? fmt::format("the key {} is set twice: set it once", written)
                           : fmt::format("{} and {} are names of one key: give one of them", other->second, written));
    const KeyLocation location = locate_key(schema, key);
    const toml::table parsed = parse_document("value = " + value, key);
    table_of(document, location, key).insert_or_assign(location.name, *parsed.get("value"));
  }
}

std::string text_of(const toml::table& document) {
  std::ostringstream out;
  out << toml::toml_formatter{document,
                              toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings};
  return out.str() + "\n";
}

std::string with_settings(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                          const EffectKinds& kinds) {
  const Schema schema(kinds);
  toml::table document = parse_document(text, path);
  replace_old_names(document, schema, path);
  apply(settings, schema, document);
  return text_of(document);
}

}  // namespace lichtenberg
