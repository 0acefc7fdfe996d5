#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/column.hpp"

namespace lichtenberg {

/// Returns a text for an instant of a run, such as "t = 0.5 s", or "iteration 12" for the time unit "1".
std::string instant_in_words(double time, const std::string& time_unit);

/// Recorded state of a run at one instant, a frame of its trajectory, as named columns (tables of numbers). The
/// simulation and the effects add columns. The recorder writes them, and analysis and pictures read them by name.
struct Frame {
  double time = 0;
  std::string time_unit = "s";  ///< "1" if time is the number of an iteration
  std::vector<Column> columns;  ///< columns with different names

  /// Adds a column with one row of `width` numbers for each particle (0: one number). Number is double, std::int64_t or
  /// std::int32_t.
  template <class Number>
  void add_particles(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::particles, width, std::move(values)});
  }
  /// Adds a column with one number for the whole system.
  template <class Number>
  void add_system(std::string name, std::string unit, Number value) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::system, 0, std::vector<Number>{value}});
  }
  /// Adds a column of the whole system with one number for each of `labels`, such as the names of terminals.
  void add_labelled(std::string name, std::string unit, std::vector<double> values, std::vector<std::string> labels);
  /// Adds a column with a variable number of rows of `width` numbers (0: one number), such as one row for each contact.
  template <class Number>
  void add_list(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::list, width, std::move(values)});
  }
  /// Adds a column with one vector for each particle from `values` [N * dimension]; `dimension` is 2 or 3. The column
  /// has three components for each vector; z is 0 in two dimensions.
  void add_vectors(std::string name, std::string unit, std::span<const double> values, int dimension);
  /// Adds a column with one vector for each particle from `values` [N].
  void add_vectors(std::string name, std::string unit, std::span<const Vec3> values);

  /// Returns the column called `name`; null if there is none.
  const Column* find(std::string_view name) const;
  /// Returns all numbers of the column `name`, row after row, as doubles; empty if there is no such column.
  std::vector<double> reals(std::string_view name) const;
  /// Returns all numbers of the column `name`, row after row, as ints; empty if there is no such column.
  std::vector<int> integers(std::string_view name) const;
  /// Returns the vectors of the particles in the column `name`, which has rows of 3 numbers; empty if there is no such
  /// column.
  std::vector<Vec3> vectors(std::string_view name) const;
  /// Returns x and y of the vectors of the particles in the column `name`; empty if there is no such column.
  std::vector<Vec2> plane_vectors(std::string_view name) const;
  /// Returns the first number of the column `name`, which has one number for the system; empty if there is none.
  std::optional<double> number(std::string_view name) const;
};

}  // namespace lichtenberg
