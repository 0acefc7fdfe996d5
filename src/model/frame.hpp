#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/column.hpp"

namespace lichtenberg {

/// Describes an instant, as in "t = 0.5 s"; for the unit "1", "iteration 12".
std::string instant_in_words(double time, const std::string& time_unit);

/// State of a run at one instant, as named columns. The integrator and the effects add columns, the recorder writes
/// them, and analysis and pictures read them by name.
struct Frame {
  double time = 0;
  std::string time_unit = "s";  ///< "1" if time is the number of an iteration
  std::vector<Column> columns;  ///< columns with different names

  /// Adds a column with one row for each particle. Number is double, std::int64_t or std::int32_t.
  template <class Number>
  void add_particles(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::particles, width, std::move(values)});
  }
  template <class Number>
  void add_system(std::string name, std::string unit, Number value) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::system, 0, std::vector<Number>{value}});
  }
  /// Adds a column with one number for each of `labels`.
  void add_labelled(std::string name, std::string unit, std::vector<double> values, std::vector<std::string> labels);
  template <class Number>
  void add_list(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::list, width, std::move(values)});
  }
  /// Adds vectors of the particles in the form of frames and files, with three components; `dimension` is 2 or 3.
  void add_vectors(std::string name, std::string unit, std::span<const double> values, int dimension);
  void add_vectors(std::string name, std::string unit, std::span<const Vec3> values);

  /// Returns the column of that name; null if there is none.
  const Column* find(std::string_view name) const;
  /// Returns the numbers of a column, converted to double; empty if there is no such column.
  std::vector<double> reals(std::string_view name) const;
  /// Returns the numbers of a column, converted to int; empty if there is no such column.
  std::vector<int> integers(std::string_view name) const;
  /// Returns the vectors of the particles; empty if there is no such column.
  std::vector<Vec3> vectors(std::string_view name) const;
  /// Returns the first two components of the particles' vectors; empty if there is no such column.
  std::vector<Vec2> plane_vectors(std::string_view name) const;
  /// Returns the number of a system column with one number; empty if there is none.
  std::optional<double> number(std::string_view name) const;
};

}  // namespace lichtenberg
