#include "src/scene/document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>
#include <vector>

#include "solvers/error.hpp"

namespace lichtenberg {

toml::table parse_document(const std::string& text, const std::string& path) {
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    const auto where = error.source().begin;
    throw InputError(fmt::format("{}:{}:{}: not a TOML file: {}", path, where.line, where.column, error.description()));
  }
}

std::string shown(const toml::node& node) {
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  std::vector<std::string> parts;
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& element : *array) parts.push_back(shown(element));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, value] : *table) parts.push_back(fmt::format("{} = {}", name.str(), shown(value)));
    return fmt::format("{{ {} }}", fmt::join(parts, ", "));
  }
  std::ostringstream out;
  out << toml::toml_formatter{
      node, toml::toml_formatter::default_flags &
                ~(toml::format_flags::allow_literal_strings | toml::format_flags::allow_multi_line_strings)};
  return out.str();
}

}  // namespace lichtenberg
