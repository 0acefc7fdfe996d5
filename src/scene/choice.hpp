#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace lichtenberg {

/// A value of an option (an enumeration, or a class with few values) with its name in scene files, messages and
/// results.
template <class E>
struct Named {
  E value;
  std::string_view name;
};

/// List of all values of an enumeration of options with their names, in the order of messages. Each such type
/// specializes it as an array or a list of Named<E>. Other types have a null pointer.
template <class E>
inline constexpr std::nullptr_t values_named{};

template <class E>
concept Enumeration = std::is_enum_v<E> || requires {
  values_named<E>[0].name;
};

/// Returns the name of a value of an enumeration; an empty text if it has none.
template <Enumeration E>
std::string name_of(E value) {
  for (const Named<E>& named : values_named<E>)
    if (named.value == value) return std::string(named.name);
  return "";
}

/// Returns the value of an enumeration with this name; empty if no value has it.
template <Enumeration E>
std::optional<E> value_of(std::string_view name) {
  for (const Named<E>& named : values_named<E>)
    if (named.name == name) return named.value;
  return {};
}

/// Returns the names of all values of an enumeration.
template <Enumeration E>
std::vector<std::string> names_of() {
  std::vector<std::string> names;
  for (const Named<E>& named : values_named<E>) names.emplace_back(named.name);
  return names;
}

/// Joins names in quotation marks for a message, as in "a", "b" and "c". Returns "none" for an empty list.
inline std::string quoted(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "\"" : i + 1 < names.size() ? ", \"" : " and \"") + names[i] + "\"";
  return text;
}

}  // namespace lichtenberg
