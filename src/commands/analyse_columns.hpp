#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "src/model/column.hpp"

namespace lichtenberg {

/// Builder of columns with one row per frame, from functions of one frame's analysis (type `FrameResult`). The
/// functions real() and integer() add a number per frame. reals() and integers() add an array, padded to the longest.
template <class FrameResult>
class Columns {
 public:
  explicit Columns(const std::vector<FrameResult>& frames) : frames_(frames) {}

  void real(const std::string& name, const std::string& unit, const std::function<double(const FrameResult&)>& get) {
    add<double>(name, unit, 0, [&](const FrameResult& f) { return std::vector{get(f)}; });
  }
  void integer(const std::string& name, const std::function<std::int64_t(const FrameResult&)>& get) {
    add<std::int64_t>(name, "1", 0, [&](const FrameResult& f) { return std::vector{get(f)}; });
  }
  /// Adds an array per frame. `missing`: padding value for arrays shorter than the longest.
  void reals(const std::string& name, const std::string& unit,
             const std::function<std::vector<double>(const FrameResult&)>& get, double missing = 0) {
    add<double>(name, unit, widest(get), get, missing);
  }
  void integers(const std::string& name, const std::function<std::vector<int>(const FrameResult&)>& get) {
    add<std::int64_t>(name, "1", widest(get), get);
  }

  std::vector<Column> take() { return std::move(columns_); }

 private:
  template <class Row>
  std::size_t widest(const Row& get) const {
    std::size_t width = 1;
    for (const FrameResult& frame : frames_) width = std::max(width, get(frame).size());
    return width;
  }

  template <class Number, class Row>
  void add(const std::string& name, const std::string& unit, std::size_t width, const Row& get, Number missing = 0) {
    std::vector<Number> values;
    for (const FrameResult& frame : frames_) {
      const auto row = get(frame);
      values.insert(values.end(), row.begin(), row.end());
      values.resize(values.size() + std::max<std::size_t>(width, 1) - row.size(), missing);
    }
    columns_.push_back({name, unit, Column::Of::list, width, std::move(values)});
  }

  const std::vector<FrameResult>& frames_;
  std::vector<Column> columns_;
};

/// Returns one row of a column as JSON: a number if column.width is 0, otherwise an array of column.width numbers.
inline nlohmann::ordered_json json_value(const Column& column, std::size_t row) {
  return std::visit(
      [&](const auto& values) -> nlohmann::ordered_json {
        if (column.width == 0) return values[row];
        const auto first = values.begin() + static_cast<std::ptrdiff_t>(row * column.width);
        return std::vector(first, first + static_cast<std::ptrdiff_t>(column.width));
      },
      column.values);
}

/// Converts columns to CSV: a header, then one line per frame. A column with several numbers per frame becomes NAME_0,
/// NAME_1, ... Non-finite numbers become empty cells.
inline std::string csv_of(const std::vector<Column>& columns, std::size_t frames) {
  std::vector<std::string> lines(frames + 1);
  // An empty line marks the first cell, because the first column is the time, which is never empty.
  const auto add = [](std::string& line, const std::string& cell) { line += (line.empty() ? "" : ",") + cell; };
  for (const Column& column : columns)
    for (std::size_t k = 0; k < std::max<std::size_t>(column.width, 1); ++k) {
      const std::string number = column.width > 1 ? fmt::format("_{}", k) : "";
      add(lines[0], column.name + number + (column.unit == "1" ? "" : " (" + column.unit + ")"));
      for (std::size_t row = 0; row < frames; ++row) {
        const nlohmann::ordered_json all = json_value(column, row), &value = all.is_array() ? all[k] : all;
        const bool is_number = value.is_number_integer() || std::isfinite(value.get<double>());
        add(lines[row + 1], is_number ? value.dump() : "");
      }
    }
  return fmt::format("{}\n", fmt::join(lines, "\n"));
}

/// Adds the members "units" and "frames" with the values of these columns to `json`. `FrameResult` has the member
/// `frame`, the frame's index.
template <class FrameResult>
void add_frames(nlohmann::ordered_json& json, const std::vector<Column>& columns,
                const std::vector<FrameResult>& frames) {
  json["units"] = nlohmann::ordered_json::object();
  json["frames"] = nlohmann::ordered_json::array();
  for (const Column& column : columns) json["units"][column.name] = column.unit;
  for (std::size_t row = 0; row < frames.size(); ++row) {
    nlohmann::ordered_json& frame = json["frames"].emplace_back();
    frame["frame"] = frames[row].frame;
    for (const Column& column : columns) frame[column.name] = json_value(column, row);
  }
}

}  // namespace lichtenberg
