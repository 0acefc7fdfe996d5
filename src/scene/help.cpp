#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>

#include "solvers/error.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/old_names.hpp"
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace {

constexpr std::size_t line_width = 100;

/// Breaks a text into lines of at most `line_width`, each indented by `indent` spaces.
std::string wrapped(const std::string& text, std::size_t indent) {
  std::string lines, line;
  const auto end_line = [&] {
    lines += std::string(line.empty() ? 0 : indent, ' ') + line + "\n";
    line.clear();
  };
  std::istringstream words(text);
  for (std::string word; words >> word; line += word) {
    if (!line.empty() && indent + line.size() + 1 + word.size() > line_width) end_line();
    if (!line.empty()) line += ' ';
  }
  end_line();
  return lines;
}

std::string help_of(const Table& table, const std::vector<Key>& keys, Draft& untouched) {
  constexpr std::size_t indent = 27;
  std::string text = fmt::format("\n{}\n{}", table.header(), wrapped(table.help, 2));
  for (const Key& key : keys) {
    const std::string help =
        wrapped(key.help, indent) + wrapped(fmt::format("{}; {}", key.allowed(), key.fallback(untouched)), indent);
    const std::string name = fmt::format("    {:<22} ", key.name);
    text += name + (name.size() > indent ? "\n" + help : help.substr(indent));
  }
  return text;
}

/// Returns the help of a table or of one key, named as "field", "effects.leakage", "leakage" or "field.cells".
std::string help_of_part(const Schema& schema, Draft& untouched, const std::string& part) {
  for (const std::string& path : {part, "effects." + part})
    if (const Table* table = schema.find_table(path)) {
      std::string text = help_of(*table, table->keys, untouched);
      for (const Table& inner : schema.tables())
        if (inner.path.starts_with(path + ".")) text += help_of(inner, inner.keys, untouched);
      return text;
    }
  for (const Table& table : schema.tables())
    for (const Key& key : table.keys)
      if (path_in(table, key.name) == part) return help_of(table, {key}, untouched);
  throw InputError(fmt::format("there is no table or key {} of a scene; the nearest is {}", part,
                               nearest_path(part, schema.known_paths())));
}

}  // namespace

std::string scene_help(const EffectKinds& kinds, const std::string& part) {
  const Schema schema(kinds);
  Draft untouched = schema.blank_draft();
  if (!part.empty()) return help_of_part(schema, untouched, without_old_names(part, schema)).substr(1);
  std::string text = wrapped(
      "A scene is a TOML file. Every number is in the unit named here, or in reduced units in a scene of grains "
      "(table [units]), and written without it; its size is 0 or from 1e-50 to 1e50 unless its key says otherwise. A "
      "[[table]] may occur any number of times. Stephenson 2018 and Singh 2019 are the dissertations with the models "
      "of conductors and of grains. `lichtenberg help scene PART` shows one table or key, as in `help scene field`.",
      0);
  for (const Table& table : schema.tables()) text += help_of(table, table.keys, untouched);
  return text;
}

}  // namespace lichtenberg
