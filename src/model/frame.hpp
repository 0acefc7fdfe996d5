#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/column.hpp"

namespace lichtenberg {

/// "t = 0.5 s"; where the unit is "1", "iteration 12".
std::string instant_in_words(double time, const std::string& time_unit);

/// What a run shows of itself at one instant, as named columns: who moves the scene and the effects add them, the
/// recorder writes them, analysis and pictures ask for them by name.
struct Frame {
  double time = 0;
  std::string time_unit = "s";  ///< "1" where time is the number of an iteration
  std::vector<Column> columns;  ///< of different names

  /// Adds a column; Number is double, std::int64_t or std::int32_t.
  template <class Number>
  void add_particles(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::particles, width, std::move(values)});
  }
  template <class Number>
  void add_system(std::string name, std::string unit, Number value) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::system, 0, std::vector<Number>{value}});
  }
  /// One number for each of `labels`.
  void add_labelled(std::string name, std::string unit, std::vector<double> values, std::vector<std::string> labels);
  template <class Number>
  void add_list(std::string name, std::string unit, std::vector<Number> values, std::size_t width = 0) {
    columns.push_back({std::move(name), std::move(unit), Column::Of::list, width, std::move(values)});
  }
  /// Vectors of the particles as they stand in frames and files, with three components; `dimension` is 2 or 3.
  void add_vectors(std::string name, std::string unit, std::span<const double> values, int dimension);
  void add_vectors(std::string name, std::string unit, std::span<const Vec3> values);

  /// Null if there is none of that name.
  const Column* find(std::string_view name) const;
  /// The numbers of a column, converted; none if there is no such column.
  std::vector<double> reals(std::string_view name) const;
  std::vector<int> integers(std::string_view name) const;
  /// Vectors of the particles; none if there is no such column.
  std::vector<Vec3> vectors(std::string_view name) const;
  /// Their first two components; none if there is no such column.
  std::vector<Vec2> plane_vectors(std::string_view name) const;
  /// Of a column of the whole with one number; empty if there is none.
  std::optional<double> number(std::string_view name) const;
};

}  // namespace lichtenberg
