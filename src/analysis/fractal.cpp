#include "src/analysis/fractal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lichtenberg::analysis {
namespace {

/// Returns scales from `from` to `to` inclusive, about 2^(1/4) apart; empty if `to` is less than twice `from`.
std::vector<double> scales(double from, double to) {
  if (!(from > 0) || !(to >= 2 * from)) return {};
  const int steps = static_cast<int>(std::lround(4 * std::log2(to / from)));
  std::vector<double> result;
  for (int k = 0; k <= steps; ++k) result.push_back(from * std::pow(to / from, static_cast<double>(k) / steps));
  return result;
}

/// Grid of square boxes over the lines; `corner` is a corner of the first box.
class Boxes {
 public:
  Boxes(Vec2 corner, double side, Vec2 high) : corner_(corner), side_(side) {
    columns_ = static_cast<int>((high.x - corner.x) / side) + 1;
    const int rows = static_cast<int>((high.y - corner.y) / side) + 1;
    entered_.resize(static_cast<std::size_t>(columns_) * rows);
  }

  /// Marks the boxes of a segment. Between two crossings with grid lines it is within one box.
  void enter(const Segment& segment) {
    const Vec2 a = (segment.first - corner_) / side_, b = (segment.second - corner_) / side_;
    crossings_.assign({0, 1});
    add_crossings(a.x, b.x);
    add_crossings(a.y, b.y);
    std::ranges::sort(crossings_);
    for (std::size_t k = 0; k + 1 < crossings_.size(); ++k) {
      const Vec2 middle = a + 0.5 * (crossings_[k] + crossings_[k + 1]) * (b - a);
      entered_[static_cast<std::size_t>(middle.y) * columns_ + static_cast<std::size_t>(middle.x)] = true;
    }
  }

  int entered() const { return static_cast<int>(std::ranges::count(entered_, true)); }

 private:
  /// Appends the positions along a segment at which a coordinate from `a` to `b` is an integer.
  void add_crossings(double a, double b) {
    for (double line = std::ceil(std::min(a, b)); line < std::max(a, b); ++line)
      if (line > std::min(a, b)) crossings_.push_back((line - a) / (b - a));
  }

  Vec2 corner_;
  double side_;
  int columns_;
  std::vector<bool> entered_;
  std::vector<double> crossings_;
};

int fewest_boxes(std::span<const Segment> line, Vec2 low, Vec2 high, double side) {
  constexpr int shifts = 4;  // positions in each direction
  int fewest = std::numeric_limits<int>::max();
  for (int i = 0; i < shifts; ++i)
    for (int j = 0; j < shifts; ++j) {
      Boxes boxes(low - side / shifts * Vec2{static_cast<double>(i), static_cast<double>(j)}, side, high);
      for (const Segment& segment : line) boxes.enter(segment);
      fewest = std::min(fewest, boxes.entered());
    }
  return fewest;
}

}  // namespace

PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y) {
  const auto n = static_cast<double>(x.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    mean_x += std::log(x[k]) / n;
    mean_y += std::log(y[k]) / n;
  }
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double u = std::log(x[k]) - mean_x, v = std::log(y[k]) - mean_y;
    xx += u * u, xy += u * v, yy += v * v;
  }
  const double scatter = std::max(0.0, yy - xy * xy / xx);  // sum of squares about the line
  return {.exponent = xy / xx,
          .standard_error = std::sqrt(scatter / (n - 2) / xx),
          .from = *std::ranges::min_element(x),
          .to = *std::ranges::max_element(x),
          .points = static_cast<int>(x.size())};
}

std::optional<PowerLaw> box_counting_dimension(std::span<const Segment> line, double from, double to) {
  const std::vector<double> side = scales(from, to);
  if (side.empty() || line.empty()) return {};
  Vec2 low = line.front().first, high = low;
  for (const auto& [a, b] : line) {
    low = {std::min({low.x, a.x, b.x}), std::min({low.y, a.y, b.y})};
    high = {std::max({high.x, a.x, b.x}), std::max({high.y, a.y, b.y})};
  }
  std::vector<double> boxes;
  for (const double s : side) boxes.push_back(fewest_boxes(line, low, high, s));
  PowerLaw fit = fit_power_law(side, boxes);
  fit.exponent = -fit.exponent;
  return fit;
}

std::optional<PowerLaw> mass_radius_dimension(std::span<const Vec2> point, double from, double to) {
  const std::vector<double> radius = scales(from, to);
  if (radius.empty()) return {};
  std::vector<double> pairs(radius.size());  // pairs[k]: pairs within radius[k] but not within radius[k - 1]
  for (std::size_t i = 0; i < point.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto k = std::ranges::lower_bound(radius, norm(point[i] - point[j])) - radius.begin();
      if (k < std::ssize(pairs)) ++pairs[k];
    }
  if (pairs.front() == 0) return {};
  for (std::size_t k = 1; k < pairs.size(); ++k) pairs[k] += pairs[k - 1];
  for (double& each : pairs) each *= 2 / static_cast<double>(point.size());
  return fit_power_law(radius, pairs);
}

}  // namespace lichtenberg::analysis
