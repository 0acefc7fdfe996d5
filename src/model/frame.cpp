#include "src/model/frame.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace lichtenberg {
namespace {

template <class Number>
std::vector<Number> converted(const Column* column) {
  if (column == nullptr) return {};
  return std::visit(
      [](const auto& values) {
        std::vector<Number> result;
        result.reserve(values.size());
        for (const auto value : values) result.push_back(static_cast<Number>(value));
        return result;
      },
      column->values);
}

}  // namespace

std::string instant_in_words(double time, const std::string& time_unit) {
  if (time_unit == "load") return fmt::format("load {:.0f}", time);
  return time_unit == "1" ? fmt::format("iteration {:.0f}", time) : fmt::format("t = {:.6g} {}", time, time_unit);
}

void Frame::add_labelled(std::string name, std::string unit, std::vector<double> values,
                         std::vector<std::string> labels) {
  const std::size_t width = labels.size();
  columns.push_back(
      {std::move(name), std::move(unit), Column::Of::system, width, std::move(values), std::move(labels)});
}

void Frame::add_vectors(std::string name, std::string unit, std::span<const double> values, int dimension) {
  std::vector<double> in_space;
  in_space.reserve(values.size() / dimension * 3);
  for (std::size_t i = 0; i < values.size(); i += dimension)
    for (int k = 0; k < 3; ++k) in_space.push_back(k < dimension ? values[i + k] : 0.0);
  add_particles(std::move(name), std::move(unit), std::move(in_space), 3);
}

void Frame::add_vectors(std::string name, std::string unit, std::span<const Vec3> values) {
  std::vector<double> components;
  components.reserve(3 * values.size());
  for (const Vec3 v : values) components.insert(components.end(), {v.x, v.y, v.z});
  add_particles(std::move(name), std::move(unit), std::move(components), 3);
}

const Column* Frame::find(std::string_view name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : &*found;
}

std::vector<double> Frame::reals(std::string_view name) const { return converted<double>(find(name)); }
std::vector<int> Frame::integers(std::string_view name) const { return converted<int>(find(name)); }

std::vector<Vec3> Frame::vectors(std::string_view name) const {
  const std::vector<double> values = reals(name);
  std::vector<Vec3> result;
  for (std::size_t k = 0; k + 2 < values.size(); k += 3) result.push_back({values[k], values[k + 1], values[k + 2]});
  return result;
}

std::vector<Vec2> Frame::plane_vectors(std::string_view name) const {
  std::vector<Vec2> result;
  for (const Vec3 v : vectors(name)) result.push_back(plane(v));
  return result;
}

std::optional<double> Frame::number(std::string_view name) const {
  const std::vector<double> values = reals(name);
  if (values.empty()) return {};
  return values.front();
}

}  // namespace lichtenberg
