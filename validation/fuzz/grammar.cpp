#include "validation/fuzz/grammar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>
#include <utility>

#include "src/effects/read_scene.hpp"
#include "src/scene/document.hpp"

namespace lichtenberg::fuzz {
namespace {

constexpr std::int64_t bodies = 5;

// Sizes near the limits of a double and of the program's own bounds.
const std::vector<std::string> numbers{"0",
                                       "-0.0",
                                       "-1",
                                       "1",
                                       "2",
                                       "3",
                                       "0.5",
                                       "1e-3",
                                       "1e3",
                                       "1e9",
                                       "-1e9",
                                       "1e-9",
                                       "1e-30",
                                       "1e30",
                                       "-1e30",
                                       "1e-50",
                                       "1e50",
                                       "-1e50",
                                       "1e-51",
                                       "1e51",
                                       "1e-100",
                                       "1e100",
                                       "1e161",
                                       "1.7e308",
                                       "-1.7e308",
                                       "1e-308",
                                       "5e-324",
                                       "nan",
                                       "inf",
                                       "-inf",
                                       "1e400",
                                       "2147483648",
                                       "4096",
                                       "0x7fffffff",
                                       "2147483647",
                                       "9223372036854775807",
                                       "-9223372036854775808",
                                       "99999999999999999999"};
const std::vector<std::string> lists{"[]",
                                     "[0]",
                                     "[1]",
                                     "[0, 0]",
                                     "[1e-3, 2e-3]",
                                     "[2, 1]",
                                     "[nan, 1]",
                                     "[0, 0, 0]",
                                     "[1e50, -1e50]",
                                     "[[0, 0], [1, 1]]",
                                     "[1, [2]]",
                                     "[\"a\"]",
                                     "[\"a\", 1]",
                                     "[1e-3, 1e-3, 1e-3, 1e-3]"};
const std::vector<std::string> words{R"("")",           R"("x")",       R"("periodic")",
                                     R"("insulating")", R"("all")",     R"("none")",
                                     R"("1 V")",        R"("1e-3 mm")", R"("\u001b[31mred\u0007")",
                                     R"("../../x")",    R"("%s%n{}")",  R"("-x")",
                                     R"("a:b")",        R"("1e400 V")"};
const std::vector<std::string> others{"true",
                                      "false",
                                      "{}",
                                      "{ potential = 1e50 }",
                                      "{ potential = nan }",
                                      "{ x = 1 }",
                                      "1979-05-27",
                                      "07:32:00",
                                      "[{}]",
                                      "'''a\nb'''",
                                      "{ amplitude = 1, frequency = 1e9 }",
                                      "{ table = [[0, 1], [1, 2]] }"};
const std::vector<int> exponents{-300, -45, -30, -20, -9, -6, -3, -2, -1, 1, 2, 3, 6, 9, 20, 30, 45, 300};

bool is_side(const std::string& key) {
  static const std::set<std::string> sides{"left", "right", "bottom", "top", "front", "back"};
  return sides.contains(key);
}

bool is_tables(const toml::node& node) { return node.is_array_of_tables(); }

double number(const toml::node* node, double otherwise) {
  return node ? node->value<double>().value_or(otherwise) : otherwise;
}

void add_tables(const toml::table& table, const std::string& path, const std::string& header, Document& document) {
  Table own{header, {}};
  for (const auto& [key, node] : table)
    if (!is_tables(node) && !(node.is_table() && !is_side(std::string(key.str()))))
      own.lines.push_back({std::string(key.str()), shown(node)});
  document.push_back(std::move(own));
  for (const auto& [key, node] : table) {
    const std::string inner = path + (path.empty() ? "" : ".") + std::string(key.str());
    if (is_tables(node))
      for (const toml::node& element : *node.as_array())
        add_tables(*element.as_table(), inner, fmt::format("[[{}]]", inner), document);
    else if (node.is_table() && !is_side(std::string(key.str())))
      add_tables(*node.as_table(), inner, fmt::format("[{}]", inner), document);
  }
}

/// Returns the smallest number of cells from 16 on for which all sides have whole numbers of them.
std::int64_t fitting_cells(const toml::array& size) {
  double longest = 0;
  for (const toml::node& side : size) longest = std::max(longest, number(&side, 1));
  for (std::int64_t cells = 16; cells < 200; ++cells)
    if (std::ranges::all_of(size, [&](const toml::node& side) {
          const double part = static_cast<double>(cells) * number(&side, 1) / longest;
          return std::abs(part - std::round(part)) < 1e-9;
        }))
      return cells;
  return 32;
}

/// Reduces populations to a few bodies. Returns the factor.
double shrink_bodies(toml::table& scene) {
  double factor = 1;
  if (toml::array* populations = scene["population"].as_array())
    for (toml::node& node : *populations) {
      const std::int64_t count = node.as_table()->get("count")->value_or(bodies);
      factor = std::max(factor, static_cast<double>(count) / bodies);
      node.as_table()->insert_or_assign("count", std::min(count, bodies));
    }
  toml::array* conductors = scene["conductor"].as_array();
  if (!conductors) return factor;
  while (conductors->size() > bodies) conductors->pop_back();
  std::set<std::string> named;
  for (toml::node& node : *conductors) named.insert((*node.as_table())["group"].value_or(std::string()));
  if (toml::array* groups = scene["group"].as_array()) {
    for (std::size_t k = groups->size(); k-- > 0;)
      if (!named.contains((*groups)[k].as_table()->get("name")->value_or(std::string())))
        groups->erase(groups->begin() + static_cast<std::ptrdiff_t>(k));
    if (groups->empty()) scene.erase("group");
  }
  return factor;
}

void shrink_domain(toml::table& scene, double factor, double least) {
  toml::array& size = *scene["domain"]["size"].as_array();
  const double scale = std::pow(factor, 1 / static_cast<double>(size.size()));
  toml::array smaller;
  for (const toml::node& side : size) smaller.push_back(std::max(number(&side, 1) / scale, least));
  scene["domain"].as_table()->insert_or_assign("size", smaller);
}

std::vector<std::pair<std::size_t, std::size_t>> tokens_of(const std::string& value) {
  std::vector<std::pair<std::size_t, std::size_t>> tokens;
  for (std::size_t at = 0; at < value.size();) {
    std::size_t end = at;
    if (value[at] == '"') {
      end = std::min(value.find('"', at + 1), value.size() - 1) + 1;
    } else {
      while (end < value.size() && (std::isalnum(static_cast<unsigned char>(value[end])) ||
                                    std::string("+-._").find(value[end]) != std::string::npos))
        ++end;
    }
    if (end > at) tokens.emplace_back(at, end - at);
    at = std::max(end, at + 1);
  }
  return tokens;
}

std::string scaled(const std::string& token, Dice& dice) {
  const bool whole = token.find_first_not_of("0123456789-") == std::string::npos;
  const double value =
      std::strtod(token.c_str(), nullptr) * std::pow(10.0, dice.of(exponents)) * (dice.chance(0.3) ? -1 : 1);
  if (whole && std::abs(value) < 1e18) return fmt::format("{}", static_cast<std::int64_t>(value));
  return std::isfinite(value) && value != 0 ? fmt::format("{:e}", value) : dice.of(numbers);
}

bool is_number(const std::string& token) {
  return (std::isdigit(static_cast<unsigned char>(token[0])) || (token[0] == '-' && token.size() > 1)) &&
         token.find_first_not_of("0123456789+-.e") == std::string::npos && std::abs(std::atof(token.c_str())) < 1e300;
}

void add_key(Document& document, const KnownKeys& known, Dice& dice) {
  auto at = known.begin();
  std::advance(at, static_cast<std::ptrdiff_t>(dice.below(known.size())));
  if (at->second.empty()) return;
  const Line line{dice.of(at->second),
                  drawn_value(dice.of(std::vector<std::string>{"1.0", "1", "[1.0, 1.0]", "\"a\""}), dice)};
  const auto there = std::ranges::find(document, at->first, &Table::header);
  there == document.end() ? document.push_back({at->first, {line}}) : there->lines.push_back(line);
}

}  // namespace

Document small_scene(const std::string& text) {
  toml::table scene = toml::parse(text);
  const bool grains = scene.contains("reference") || scene.contains("units"),
             packing = scene["effects"]["soft_repulsion"].is_table();
  const double factor = shrink_bodies(scene);
  if (factor > 1 && (grains || packing)) shrink_domain(scene, factor, grains ? 4 : 0);
  if (!grains && !packing) {
    toml::table* field = scene.insert("field", toml::table{}).first->second.as_table();
    if (field->contains("accuracy"))
      field->insert_or_assign("accuracy", 0.1);
    else if (scene["domain"]["size"].is_array())
      field->insert_or_assign("cells", fitting_cells(*scene["domain"]["size"].as_array()));
  }
  toml::table* output = scene.insert("output", toml::table{}).first->second.as_table();
  output->insert_or_assign("picture", false);
  if (packing) {
    output->erase("every");
  } else {
    toml::table* stop = scene.insert("stop", toml::table{}).first->second.as_table();
    const double time = grains ? 0.02 : 1e-4;
    stop->insert_or_assign("time", time);
    output->insert_or_assign("every", time / 2);
  }
  if (toml::array* stages = scene["equilibration"].as_array())
    for (toml::node& stage : *stages) stage.as_table()->insert_or_assign("duration", 0.01);
  Document document;
  add_tables(scene, "", "", document);
  return document;
}

KnownKeys known_keys() {
  KnownKeys known;
  std::istringstream help(scene_help());
  std::string line, header;
  while (std::getline(help, line)) {
    if (line.starts_with("[")) known[header = line.substr(0, line.find_last_of(']') + 1)];
    if (header.empty() || line.size() < 5 || !line.starts_with("    ") || line[4] == ' ') continue;
    const std::string word = line.substr(4, line.find(' ', 4) - 4);
    if (std::ranges::all_of(word, [](unsigned char c) { return std::isalnum(c) || c == '_'; }))
      known[header].push_back(word);
  }
  return known;
}

std::string drawn_value(const std::string& before, Dice& dice) {
  const auto tokens = tokens_of(before);
  if (!tokens.empty() && dice.chance(0.75)) {
    const auto [at, length] = dice.of(tokens);
    const std::string token = before.substr(at, length);
    const std::string now = is_number(token)  ? (dice.chance(0.6) ? scaled(token, dice) : dice.of(numbers))
                            : token[0] == '"' ? dice.of(words)
                                              : dice.of(numbers);
    return before.substr(0, at) + now + before.substr(at + length);
  }
  return dice.of(dice.of(std::vector{&numbers, &numbers, &lists, &words, &others})[0]);
}

void change(Document& document, const Grammar& grammar, Dice& dice) {
  if (document.empty() || dice.chance(0.15)) return add_key(document, grammar.known, dice);
  if (dice.chance(0.06)) return document.push_back(dice.of(dice.of(grammar.scenes)));
  const std::size_t k = dice.below(document.size());
  if (dice.chance(0.04)) {
    document.erase(document.begin() + static_cast<std::ptrdiff_t>(k));
    return;
  }
  if (dice.chance(0.03)) return document.push_back(Table(document[k]));
  std::vector<Line>& lines = document[k].lines;
  if (lines.empty()) return;
  const std::size_t l = dice.below(lines.size());
  if (dice.chance(0.08)) {
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(l));
    return;
  }
  if (dice.chance(0.04)) return lines.push_back(Line(lines[l]));
  if (dice.chance(0.02))
    lines[l].key = dice.of(std::vector<std::string>{"x", "\"\"", "a.b", lines[l].key + "s", "'\t'"});
  lines[l].value = drawn_value(lines[l].value, dice);
}

std::string with_changed_characters(std::string text, Dice& dice) {
  static constexpr char characters[] = "\"'[]{}=#\n\r\t.,\\\0\x1b\xff\xc3\xa9-e0";
  static const std::string special(characters, sizeof characters - 1);
  for (std::size_t k = 1 + dice.below(3); k > 0 && !text.empty(); --k) {
    const std::size_t at = dice.below(text.size()), length = 1 + dice.below(dice.chance(0.2) ? 200 : 3);
    if (dice.chance(0.4))
      text[at] = dice.of(special);
    else if (dice.chance(0.5))
      text.insert(at,
                  dice.chance(0.5) ? std::string(1, dice.of(special)) : text.substr(dice.below(text.size()), length));
    else
      text.erase(at, length);
  }
  return text;
}

std::string text_of(const Document& document) {
  std::string text;
  for (const Table& table : document) {
    text += table.header + "\n";
    for (const Line& line : table.lines) text += line.key + " = " + line.value + "\n";
  }
  return text;
}

}  // namespace lichtenberg::fuzz
