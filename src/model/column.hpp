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

/// A named quantity of a frame or result file, as a table of numbers with `width` numbers in each row (0: one number).
struct Column {
  /// Meaning of the rows of a column.
  enum class Of {
    particles,  ///< one row for each particle
    system,     ///< one row
    list        ///< a variable number of rows: contacts, iterations
  };
  std::string name;
  std::string unit;  ///< SI, as "m s-1", or reduced, as "d0"; "1": a pure number
  Of of = Of::system;
  std::size_t width = 0;  ///< numbers in a row; 0: one number, not an array
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>> values{};
  /// Labels of the numbers in a row (the names of terminals, say); may be empty.
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

/// Named group of columns of a result file that belong to no frame, such as a time series.
struct ColumnGroup {
  std::string name;
  std::vector<Column> columns;
};

}  // namespace lichtenberg
