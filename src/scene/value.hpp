#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "src/scene/draft.hpp"

namespace lichtenberg {

// Types of a scene's values. Each type has `read` (false for a TOML value of another type), `type_name` (as in "it must
// be ...") and `show` (as written in a scene file). `numbers` returns the numbers to which a key's range and unit
// apply. Enumerations are read as texts (AtChoice).

inline bool read(const toml::node& node, double& value) {
  // node.value<double>() is not used because it is empty for integers that a double cannot represent exactly.
  if (const auto* integer = node.as_integer())
    value = static_cast<double>(integer->get());
  else if (const auto* number = node.as_floating_point())
    value = number->get();
  else
    return false;
  return true;
}
inline const char* type_name(const double&) { return "a number"; }
inline std::string show(const double& value) { return fmt::format("{:g}", value); }
inline std::vector<double> numbers(const double& value) { return {value}; }

inline bool read(const toml::node& node, std::int64_t& value) {
  if (!node.is_integer()) return false;
  value = *node.value<std::int64_t>();
  return true;
}
inline const char* type_name(const std::int64_t&) { return "an integer"; }
inline std::string show(const std::int64_t& value) { return std::to_string(value); }
inline std::vector<double> numbers(const std::int64_t& value) { return {static_cast<double>(value)}; }

/// Reads an integer from a TOML value. Integers beyond the range of int become the nearest int, which the key's range
/// must refuse.
inline bool read(const toml::node& node, int& value) {
  std::int64_t wide = 0;
  if (!read(node, wide)) return false;
  using Limits = std::numeric_limits<int>;
  value = static_cast<int>(std::clamp<std::int64_t>(wide, Limits::min(), Limits::max()));
  return true;
}
inline const char* type_name(const int&) { return "an integer"; }
inline std::string show(const int& value) { return std::to_string(value); }
inline std::vector<double> numbers(const int& value) { return {static_cast<double>(value)}; }

inline bool read(const toml::node& node, bool& value) {
  if (!node.is_boolean()) return false;
  value = *node.value<bool>();
  return true;
}
inline const char* type_name(const bool&) { return "true or false"; }
inline std::string show(const bool& value) { return value ? "true" : "false"; }
inline std::vector<double> numbers(const bool&) { return {}; }

/// Returns true if a text in UTF-8 has control characters other than newline and tab, which could change the state of a
/// terminal.
inline bool has_control_characters(const std::string& text) {
  for (std::size_t k = 0; k < text.size(); ++k) {
    const unsigned char c = text[k], next = k + 1 < text.size() ? text[k + 1] : 0;
    if ((c < 0x20 && c != '\n' && c != '\t') || c == 0x7f || (c == 0xc2 && next >= 0x80 && next < 0xa0)) return true;
  }
  return false;
}

inline bool read(const toml::node& node, std::string& value) {
  if (!node.is_string()) return false;
  value = *node.value<std::string>();
  return !value.empty() && !has_control_characters(value);
}
inline const char* type_name(const std::string&) { return "a text, not empty, without control characters"; }
inline std::string show(const std::string& value) { return '"' + value + '"'; }
inline std::vector<double> numbers(const std::string&) { return {}; }

inline bool read(const toml::node& node, Vec2& value) {
  const toml::array* pair = node.as_array();
  return pair && pair->size() == 2 && read((*pair)[0], value.x) && read((*pair)[1], value.y);
}
inline const char* type_name(const Vec2&) { return "two numbers [x, y]"; }
inline std::string show(const Vec2& value) { return fmt::format("[{:g}, {:g}]", value.x, value.y); }
inline std::vector<double> numbers(const Vec2& value) { return {value.x, value.y}; }

inline bool read(const toml::node& node, Coordinates& value) {
  const toml::array* components = node.as_array();
  if (!components || components->size() < 2 || components->size() > 3) return false;
  value.count = static_cast<int>(components->size());
  for (int k = 0; k < value.count; ++k)
    if (!read((*components)[k], value.value[k])) return false;
  return true;
}
inline const char* type_name(const Coordinates&) { return "two numbers [x, y] or three [x, y, z]"; }
inline std::string show(const Coordinates& value) {
  return value.count == 3 ? fmt::format("[{:g}, {:g}, {:g}]", value.value.x, value.value.y, value.value.z)
                          : show(plane(value.value));
}
inline std::vector<double> numbers(const Coordinates& value) {
  const auto [x, y, z] = value.value;
  return value.count == 3 ? std::vector<double>{x, y, z} : std::vector<double>{x, y};
}

/// Reads a list that is not empty, of elements for which there is a function read() above.
template <class Element>
bool read(const toml::node& node, std::vector<Element>& value) {
  const toml::array* list = node.as_array();
  if (!list) return false;
  value.assign(list->size(), {});
  for (std::size_t k = 0; k < list->size(); ++k)
    if (!read((*list)[k], value[k])) return false;
  return !value.empty();
}
inline const char* type_name(const std::vector<double>&) { return "a non-empty list of numbers"; }
inline std::string show(const std::vector<double>& value) { return fmt::format("[{}]", fmt::join(value, ", ")); }
inline std::vector<double> numbers(const std::vector<double>& value) { return value; }

inline const char* type_name(const std::vector<Vec2>&) { return "a list of points [[x, y], ...]"; }
inline std::string show(const std::vector<Vec2>& value) {
  std::vector<std::string> points;
  for (const Vec2 point : value) points.push_back(show(point));
  return fmt::format("[{}]", fmt::join(points, ", "));
}
inline std::vector<double> numbers(const std::vector<Vec2>& value) {
  std::vector<double> all;
  for (const Vec2 point : value) all.insert(all.end(), {point.x, point.y});
  return all;
}

inline bool read(const toml::node& node, Interval& value) {
  if (read(node, value.smallest)) {
    value.largest = value.smallest;
    return true;
  }
  Vec2 pair;
  if (!read(node, pair)) return false;
  value = {pair.x, pair.y};
  return true;
}
inline const char* type_name(const Interval&) { return "a number or two numbers [smallest, largest]"; }
inline std::string show(const Interval& value) { return fmt::format("[{:g}, {:g}]", value.smallest, value.largest); }
inline std::vector<double> numbers(const Interval& value) { return {value.smallest, value.largest}; }

inline bool read(const toml::node& node, Region& value) {
  const toml::array* pair = node.as_array();
  return pair && pair->size() == 2 && read((*pair)[0], value.lower) && read((*pair)[1], value.upper) &&
         value.lower.count == value.upper.count;
}
inline const char* type_name(const Region&) {
  return "two corners [[left, bottom], [right, top]] or [[left, bottom, front], [right, top, back]]";
}
inline std::string show(const Region& value) { return "[" + show(value.lower) + ", " + show(value.upper) + "]"; }
inline std::vector<double> numbers(const Region& value) {
  std::vector<double> all = numbers(value.lower);
  for (const double number : numbers(value.upper)) all.push_back(number);
  return all;
}

/// Reads the points of a waveform, [[t0, V0], [t1, V1], ...].
inline bool read_points(const toml::node* node, std::vector<Vec2>& points) {
  const toml::array* list = node ? node->as_array() : nullptr;
  if (!list) return false;
  points.resize(list->size());
  for (std::size_t k = 0; k < list->size(); ++k)
    if (!read((*list)[k], points[k])) return false;
  return true;
}

/// Reads a sine or a square wave: its numbers, and its shape.
inline bool read_wave(const toml::table& keys, Waveform& wave) {
  wave.shape = Waveform::Shape::sine;
  for (const auto& [name, node] : keys) {
    const std::string_view key = name.str();
    if (key == "shape") {
      const std::string shape = node.value<std::string>().value_or("");
      if (shape != "sine" && shape != "square") return false;
      if (shape == "square") wave.shape = Waveform::Shape::square;
      continue;
    }
    double* const number = key == "amplitude"   ? &wave.amplitude
                           : key == "frequency" ? &wave.frequency
                           : key == "offset"    ? &wave.offset
                           : key == "phase"     ? &wave.phase
                                                : nullptr;
    if (!number || !read(node, *number)) return false;
  }
  return keys.contains("amplitude") && keys.contains("frequency");
}

inline bool read(const toml::node& node, Signal& value) {
  if (read(node, value.value)) return true;
  const toml::table* keys = node.as_table();
  if (!keys) return false;
  Waveform waveform;
  waveform.covers_run = keys->contains("table");
  const char* points = waveform.covers_run ? "table" : "ramp";
  const bool valid = keys->contains(points) ? keys->size() == 1 && read_points(keys->get(points), waveform.points)
                                            : read_wave(*keys, waveform);
  if (valid) value = Signal(std::move(waveform));
  return valid;
}
inline const char* type_name(const Signal&) {
  return "a number, { ramp = [[t0, value], [t1, value], ...] }, { table = \"file.csv\" or points as of a ramp } or { "
         "amplitude = a number, frequency = a number in Hz, offset = 0, phase = 0 (degrees), shape = \"sine\" or "
         "\"square\" }";
}
inline std::string show(const Signal& signal) {
  return signal.varies() ? "a function of time" : fmt::format("{:g}", signal.value);
}
inline std::vector<double> numbers(const Signal& signal) {
  if (!signal.varies()) return {signal.value};
  const Waveform& wave = *signal.waveform;
  std::vector<double> all{wave.amplitude, wave.frequency, wave.offset, wave.phase};
  for (const Vec2 point : wave.points) all.insert(all.end(), {point.x, point.y});
  return all;
}

inline bool read(const toml::node& node, DomainSide& value) {
  if (node.is_string()) {
    value.periodic = *node.value<std::string>() == "periodic";
    return value.periodic || *node.value<std::string>() == "insulating";
  }
  const toml::table* electrode = node.as_table();
  if (!electrode || electrode->empty()) return false;
  value.electrode = true;
  for (const auto& [name, number] : *electrode) {
    const std::string_view key = name.str();
    if (key == "potential" ? !read(number, value.potential)
        : key == "series_resistance"
            ? !read(number, value.series_resistance.emplace()) || !(*value.series_resistance > 0)
        : key == "charge" ? !read(number, value.charge.emplace())
                          : true)
      return false;
  }
  return electrode->contains("potential") != electrode->contains("charge") &&
         (electrode->contains("potential") || electrode->size() == 1);
}
inline const char* type_name(const DomainSide&) {
  return "\"periodic\", \"insulating\", { potential = a number in V or a function of time } (also with "
         "series_resistance = a number in ohm, greater than 0) or { charge = a number in C }";
}
inline std::string show(const DomainSide& side) {
  if (side.electrode) return fmt::format("{{ potential = {} }}", show(side.potential));
  return side.periodic ? "\"periodic\"" : "\"insulating\"";
}
inline std::vector<double> numbers(const DomainSide& side) {
  std::vector<double> all = numbers(side.potential);
  for (const auto& optional : {side.series_resistance, side.charge})
    if (optional) all.push_back(*optional);
  return all;
}

inline const char* type_name(const std::vector<std::string>&) { return "a non-empty list of texts"; }
inline std::string show(const std::vector<std::string>& value) { return fmt::format("[{}]", fmt::join(value, ", ")); }
inline std::vector<double> numbers(const std::vector<std::string>&) { return {}; }

/// Reads an optional value from a TOML value: that of a key without a default, or with a default that depends on other
/// keys.
template <class T>
bool read(const toml::node& node, std::optional<T>& value) {
  return read(node, value.emplace());
}
template <class T>
const char* type_name(const std::optional<T>&) {
  return type_name(T{});
}
template <class T>
std::string show(const std::optional<T>& value) {
  return value ? show(*value) : "none";
}
template <class T>
std::vector<double> numbers(const std::optional<T>& value) {
  return value ? numbers(*value) : std::vector<double>{};
}

/// Multiplies the numbers of a value by a factor. Values of other types have no unit of grains.
template <class T>
void scale(T&, double) {}
inline void scale(double& value, double factor) { value *= factor; }
inline void scale(Coordinates& value, double factor) { value.value *= factor; }
inline void scale(Interval& value, double factor) { value.smallest *= factor, value.largest *= factor; }
inline void scale(Region& value, double factor) { scale(value.lower, factor), scale(value.upper, factor); }
inline void scale(std::vector<double>& values, double factor) {
  for (double& value : values) value *= factor;
}
template <class T>
void scale(std::optional<T>& value, double factor) {
  if (value) scale(*value, factor);
}

/// Returns the fault of a function of time in a value whose type and ranges are right; empty if there is none.
inline std::string fault_of(const Signal& signal) { return signal.varies() ? signal.waveform->fault() : ""; }
inline std::string fault_of(const DomainSide& side) { return fault_of(side.potential); }
inline std::string fault_of(const std::optional<Signal>& signal) { return signal ? fault_of(*signal) : ""; }
template <class T>
std::string fault_of(const T&) {
  return "";
}

}  // namespace lichtenberg
