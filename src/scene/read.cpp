#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/error.hpp"
#include "src/scene/circuits.hpp"
#include "src/scene/document.hpp"
#include "src/scene/grains.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/old_names.hpp"
#include "src/scene/schema.hpp"
#include "src/scene/si.hpp"
#include "src/scene/stopping.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {
namespace {

int line_of(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

/// Line number of a key that was set elsewhere (--set), so that the key counts as given.
constexpr int set_elsewhere = std::numeric_limits<int>::max();

int line_or_marker(const toml::node& node) { return line_of(node) > 0 ? line_of(node) : set_elsewhere; }

/// Returns the value found, for a message; a short description if the value is long.
std::string found(const toml::node& node) {
  constexpr std::size_t longest = 60;
  if (const toml::table* table = node.as_table(); table && !table->is_inline()) return "a table";
  const std::string text = shown(node);
  if (text.size() <= longest && text.find('\n') == std::string::npos) return text;
  return node.is_array() ? "an array" : text.substr(0, longest) + "...";
}

/// Describes the keys of a floating conductor of any shape.
constexpr const char* floating_shape =
    "a floating conductor of this shape is an [[electrode]] with a charge instead of a potential";

/// True for vectors, whose components may have any size below smallest_size.
template <class T>
constexpr bool is_vector =
    std::is_same_v<T, Vec2> || std::is_same_v<T, Coordinates> || std::is_same_v<T, std::vector<Vec2>> ||
    std::is_same_v<T, std::optional<Coordinates>> || std::is_same_v<T, std::optional<Region>>;

/// Reads a TOML document into a draft, guided by the schema. A draft of grains in SI (Scene::in_si) with a reference
/// gets its numbers in reduced units.
class Reader {
 public:
  Reader(const Schema& schema, Draft& draft) : schema_(schema), draft_(draft) {}

  /// Largest magnitude of the numbers in each unit of a key, of a draft of grains in SI
  const std::map<std::string, double>& largest() const { return largest_; }

  void read_document(const toml::table& document) {
    check_required_tables(document);
    read_table(schema_.tables().front(), document);
  }

 private:
  void read_table(const Table& table, const toml::table& node) {
    draft_.lines[table.path] = line_or_marker(node);
    table.open(draft_, line_of(node));
    for (const auto& [name, value] : node) {
      const std::string path = path_in(table, name.str());
      if (const Table* inner = schema_.find_table(path)) {
        read_inner_table(*inner, value);
      } else if (const Key* key = find_key(table, name.str())) {
        draft_.lines[path] = line_or_marker(value);
        read_key(path, *key, value);
      } else {
        refuse_unknown(path, static_cast<int>(name.source().begin.line));
      }
    }
    check_presence(table, node);
  }

  void read_inner_table(const Table& table, const toml::node& node) {
    if (table.kind != Table::Kind::repeated) {
      if (!node.is_table()) refuse_form(table, node);
      return read_table(table, *node.as_table());
    }
    if (!node.is_array()) refuse_form(table, node);
    for (const toml::node& element : *node.as_array()) {
      if (!element.is_table()) refuse_form(table, element);
      read_table(table, *element.as_table());
    }
  }

  void read_key(const std::string& path, const Key& key, const toml::node& node) {
    const bool is_charge = draft_.scene.in_si && (key.unit == "C" || key.unit == "q0");
    const std::optional<double> coulombs = is_charge ? coulombs_of(node) : std::nullopt;
    const toml::value<double> charge(coulombs.value_or(0));  // messages show the written node, which has a line
    const toml::node& in_unit = coulombs ? static_cast<const toml::node&>(charge) : node;
    const auto read_into = [&](auto& value) {
      if (!read(in_unit, value)) refuse_value(path, key, node, "has the wrong unit or type");
      if (!std::ranges::all_of(numbers(value), [&](double number) { return key.range.contains(number); }))
        refuse_value(path, key, node, "is not allowed");
      const auto has_size = [&](double number) {
        return (is_vector<std::decay_t<decltype(value)>> && std::abs(number) < smallest_size &&
                key.range.contains(0)) ||
               key.range.allows_size_of(number);
      };
      if (const std::string fault = fault_of(value); !fault.empty())
        refuse(line_of(node), fmt::format("{} = {} is not allowed: {}", path, found(node), fault));
      if (!std::ranges::all_of(numbers(value), has_size))
        refuse_value(
            path, key, node,
            fmt::format("is not allowed: its magnitude must be 0 or from {:g} to {:g}", smallest_size, largest_size));
      if (draft_.scene.in_si) convert(path, key, node, value);
    };
    std::visit(Overloaded{[&](const AtChoice& at) {
                            std::string name;
                            read_into(name);
                            at.set(draft_, name);
                          },
                          [&]<class T>(At<T> at) { read_into(*at(draft_)); }},
               key.target);
    const std::vector<std::string> choices = key.choices();
    if (!choices.empty() && std::ranges::find(choices, *node.value<std::string>()) == choices.end())
      refuse_value(path, key, node, "is not allowed");
  }

  /// Converts a value of grains from SI to the reduced units of the draft, if it has them already.
  void convert(const std::string& path, const Key& key, const toml::node& node, auto& value) {
    if (key.scale == Key::Scale::reduced)
      refuse(line_of(node), fmt::format("{} is not allowed without [units], by whose scales it is defined: leave it "
                                        "out, or use the keys in SI of this table",
                                        path));
    if (key.unit.empty() || key.scale == Key::Scale::si) return;
    for (const double number : numbers(value)) {
      double& most = largest_[key.unit];
      most = std::max(most, std::abs(number));
    }
    if (!draft_.scene.reference) return;
    const auto unit = reduced_unit(key.unit, *draft_.scene.reference);
    if (unit) return scale(value, 1 / *unit);
    // Other tables with such units do not belong to grains: check_grains() refuses them.
    if (path.starts_with("effects."))
      refuse(line_of(node), fmt::format("{} needs the table [units], because it is in {}", path, key.unit));
  }

  void check_presence(const Table& table, const toml::table& node) {
    for (const Key& key : table.keys) {
      const bool given = node.contains(key.name);
      if (key.required && !given) refuse_missing(table, key, line_of(node), table.header());
      if (key.shapes.empty() && key.optional_shapes.empty()) continue;
      const std::string& shape = draft_.electrodes.back().shape;
      const std::vector<std::string>& shapes = key.shapes.empty() ? key.optional_shapes : key.shapes;
      const bool wanted = std::ranges::find(shapes, shape) != shapes.end();
      if (wanted && !given && !key.shapes.empty())
        refuse_missing(table, key, line_of(node), fmt::format("an electrode with shape = \"{}\"", shape));
      if (given && !wanted)
        refuse(line_of(*node.get(key.name)),
               fmt::format("{} does not belong to an electrode with shape = \"{}\", only to {}",
                           path_in(table, key.name), shape, fmt::join(shapes, ", ")));
    }
  }

  void check_required_tables(const toml::table& document) const {
    for (const Table& table : schema_.tables())
      if (table.kind == Table::Kind::required && !document.contains(table.path))
        refuse(0, fmt::format("the table {} is missing: every scene needs it", table.header()));
  }

  [[noreturn]] void refuse(int line, const std::string& message) const {
    lichtenberg::refuse(draft_.scene.path, line, message);
  }

  [[noreturn]] void refuse_value(const std::string& path, const Key& key, const toml::node& node,
                                 const std::string& fault) const {
    const toml::array* several = node.as_array();
    const bool text = node.is_string() || (several && !several->empty() && several->front().is_string());
    const bool united = text && !key.unit.empty() && !(draft_.scene.in_si && coulombs_of(node));
    refuse(line_of(node), fmt::format("{} = {} {}: it must be {}{}", path, found(node), fault, key.allowed(),
                                      united ? ", written without the unit" : ""));
  }

  [[noreturn]] void refuse_form(const Table& table, const toml::node& node) const {
    refuse(line_of(node),
           fmt::format("{} = {} has the wrong type: it must be a table{}, headed {}", table.path, found(node),
                       table.kind == Table::Kind::repeated ? " for each" : "", table.header()));
  }

  [[noreturn]] void refuse_missing(const Table& table, const Key& key, int line, const std::string& subject) const {
    const std::string path = path_in(table, key.name);
    refuse(line, fmt::format("{} is missing: {} needs it, {}", path, subject, key.allowed()));
  }

  /// Throws InputError for an unknown key. For keys of a floating conductor of another shape the message describes the
  /// alternative, for others the nearest key.
  [[noreturn]] void refuse_unknown(const std::string& path, int line) const {
    constexpr std::string_view shape_keys[] = {"conductor.shape", "conductor.side",  "conductor.from",
                                               "conductor.to",    "conductor.width", "electrode.floating",
                                               "electrode.group"};
    if (std::ranges::find(shape_keys, path) != std::end(shape_keys))
      refuse(line, fmt::format("unknown key {}: {}", path, floating_shape));
    refuse(line,
           fmt::format("unknown key {}: the nearest known key is {}", path, nearest_path(path, schema_.known_paths())));
  }

  const Schema& schema_;
  Draft& draft_;
  std::map<std::string, double> largest_;
};

std::string read_text(const std::string& path) {
  std::error_code error;
  const auto type = std::filesystem::status(path, error).type();
  if (type == std::filesystem::file_type::not_found) throw InputError(path + ": there is no such scene file");
  if (error) throw InputError(path + ": this scene file cannot be read (" + error.message() + ")");
  if (type == std::filesystem::file_type::directory) throw InputError(path + " is a directory, not a scene file");
  if (type != std::filesystem::file_type::regular)
    throw InputError(path + " is not a regular file, as a scene file is");
  constexpr std::uintmax_t most = 100'000'000;  // B; enough for a million individually given bodies
  if (const std::uintmax_t size = std::filesystem::file_size(path, error); !error && size > most)
    throw InputError(fmt::format("the scene file {} has {} bytes: at most {} are allowed", path, size, most));
  std::ifstream file(path, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file) throw InputError(path + ": this scene file cannot be read");
  return text;
}

Draft read_draft(const std::string& text, const std::string& path, const EffectKinds& kinds,
                 const std::vector<Setting>& settings) {
  const Schema schema(kinds);
  toml::table document = parse_document(text, path);
  Draft draft;
  draft.scene.warnings = replace_old_names(document, schema, path);
  for (const Setting& setting : settings)
    if (const std::string name = without_old_names(setting.key, schema); name != setting.key)
      draft.scene.warnings.push_back(old_name_warning(setting.key, name));
  apply(settings, schema, document);
  const bool tables = insert_tables(document, path);
  draft.scene.path = path;
  draft.scene.text = settings.empty() && !tables ? text : text_of(document);
  refuse_mixed_effects(document, kinds, path);
  if (is_of_grains_in_si(document, kinds)) {
    Draft in_si = draft;
    in_si.scene.in_si = draft.scene.in_si = true;
    Reader reader(schema, in_si);
    reader.read_document(document);
    draft.scene.reference = choose_reference(in_si, reader.largest());
  }
  Reader(schema, draft).read_document(document);
  return draft;
}

}  // namespace

std::string location_prefix(const std::string& path, int line) {
  return line > 0 && line != set_elsewhere ? fmt::format("{}:{}: ", path, line) : path + ": ";
}

void refuse(const std::string& path, int line, const std::string& message) {
  throw InputError(location_prefix(path, line) + message);
}

void refuse_if_given(const Draft& draft, const std::string& key, const std::string& predicate) {
  if (const int line = draft.line(key); line > 0)
    refuse(draft.scene.path, line, (key.find('.') == std::string::npos ? "[" + key + "] " : key + " ") + predicate);
}

void check_values(const std::string& text, const std::string& path, const std::vector<Setting>& settings,
                  const EffectKinds& kinds) {
  read_draft(text, path, kinds, settings);
}

Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings, const StopRequest& stop, const std::vector<Conductor>& bodies) {
  Draft draft = read_draft(text, path, kinds, settings);
  draft.scene.effects.sort(kinds);
  set_dimension(draft);
  connect_circuits(draft);
  if (draft.scene.reference) fill_in_grains(draft);
  return complete(draft, stop, bodies);
}

Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings) {
  return parse_scene(text, path, kinds, settings, {});
}

Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings) {
  return read_scene(path, kinds, settings, {});
}

Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings,
                 const StopRequest& stop, const std::vector<Conductor>& bodies) {
  return parse_scene(read_text(path), path, kinds, settings, stop, bodies);
}

}  // namespace lichtenberg
