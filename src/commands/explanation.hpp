#pragma once

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace lichtenberg {

/// Text of the command `explain`, and the same numbers as JSON.
struct Explanation {
  std::string text;
  nlohmann::ordered_json json;

  /// Appends formatted values to the text of `explain`.
  template <class... Values>
  void print(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
  }
  /// Adds a number to the JSON. `unit`: "1" for a number without unit.
  template <class Number>
  void add(const std::string& name, Number value, const std::string& unit) {
    json["quantities"][name] = {{"value", value}, {"unit", unit}};
  }
  /// Appends the reason why a run of the scene is refused to the text, and stores it in the JSON.
  void refuse(const std::string& reason) {
    print("  a run                refused: {}\n", reason);
    json["refused"] = reason;
  }
};

}  // namespace lichtenberg
