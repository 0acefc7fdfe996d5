#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace lichtenberg {

/// A named quantity as rows of numbers. Who writes or reads it need not know what it means.
struct Column {
  enum class Of {
    particles,  ///< a row for each particle
    system,     ///< one row
    list        ///< rows of something whose number varies: contacts, iterations
  };
  std::string name;
  std::string unit;     ///< SI, as "m s-1"; "1": a pure number
  Of of = Of::system;
  std::size_t width = 0;  ///< numbers a row; 0: one number, which is no array
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>> values{};
  /// What the numbers of a row belong to (the names of terminals, say); may be empty.
  std::vector<std::string> labels{};

  std::size_t size() const {
    return std::visit([](const auto& numbers) { return numbers.size(); }, values);
  }
  std::size_t rows() const { return size() / (width > 0 ? width : 1); }
  std::size_t bytes() const {
    return std::visit([](const auto& n) { return n.size() * sizeof(typename std::decay_t<decltype(n)>::value_type); },
                      values);
  }
};

/// What there is to see at one instant.
struct FrameColumns {
  double time = 0;
  std::string time_unit = "s";  ///< "1" where time is the number of an iteration
  std::vector<Column> columns;  ///< of different names
};

}  // namespace lichtenberg
