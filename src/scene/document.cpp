#include "src/scene/document.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <sstream>
#include <string_view>

#include "solvers/error.hpp"
#include "src/scene/signal.hpp"

namespace lichtenberg {

namespace {

/// Throws InputError for keys of more than 1000 parts. The parser nests one table for each part, and recursion over
/// such a table would overflow the stack. The parser itself limits nested arrays and inline tables.
void check_nesting(const std::string& text, const std::string& path) {
  constexpr int most = 1000;
  int line = 1, dots = 0;
  char until = 0;  // character that ends a text or a comment
  for (const char c : text) {
    if (c == '\n') ++line, until = 0;
    if (until != 0) {
      if (c == until) until = 0;
    } else if (c == '"' || c == '\'') {
      until = c;
    } else if (c == '#') {
      until = '\n';
    } else if (c == '.') {
      if (++dots == most)
        throw InputError(fmt::format("{}:{}: a key with more than {} parts is not allowed", path, line, most));
    } else if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) {
      dots = 0;
    }
  }
}

}  // namespace

toml::table parse_document(const std::string& text, const std::string& path) {
  check_nesting(text, path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    const auto where = error.source().begin;
    throw InputError(fmt::format("{}:{}:{}: not a TOML file: {}", path, where.line, where.column, error.description()));
  }
}

namespace {

/// Reads the points of a table of the scene's file `path`.
toml::array points_of(const toml::node& file, const std::string& path) {
  toml::array points;
  try {
    const auto table = std::filesystem::path(path).parent_path() / *file.value<std::string>();
    for (const Vec2 point : read_points(table.string())) points.push_back(toml::array{point.x, point.y});
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}:{}: {}", path, file.source().begin.line, error.what()));
  }
  return points;
}

}  // namespace

bool insert_tables(toml::table& document, const std::string& path) {
  bool any = false;
  for (auto&& [name, node] : document) {
    if (toml::array* list = node.as_array())
      for (toml::node& element : *list)
        if (toml::table* inner = element.as_table()) any = insert_tables(*inner, path) || any;
    toml::table* const inner = node.as_table();
    if (!inner) continue;
    const bool source = name == "potential" || name == "current";
    const toml::node* file = source ? inner->get("table") : nullptr;
    if (!file || !file->is_string()) {
      any = insert_tables(*inner, path) || any;
      continue;
    }
    inner->insert_or_assign("table", points_of(*file, path));
    any = true;
  }
  return any;
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
