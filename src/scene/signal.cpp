#include "src/scene/signal.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

#include <fmt/format.h>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// A point whose time differs by less than this (s) from `time` is at this time: rounding of times that steps add up.
double rounding_of_time_at(double time) { return 1e-12 * std::abs(time); }

/// A number of half periods that differs by less than this from an integer is that integer.
double rounding_of_half_periods(double halves) { return 1e-9 + 1e-13 * std::abs(halves); }

}  // namespace

double Waveform::polygon(double time, bool after) const {
  const double rounding = rounding_of_time_at(time);
  const auto next = after ? std::ranges::upper_bound(points, time + rounding, {}, &Vec2::x)
                          : std::ranges::lower_bound(points, time - rounding, {}, &Vec2::x);
  if (next == points.begin()) return next->y;
  const Vec2 from = *(next - 1);
  if (next == points.end()) return from.y;
  const double share = std::clamp((time - from.x) / (next->x - from.x), 0.0, 1.0);
  return std::lerp(from.y, next->y, share);
}

/// Returns the half periods of a square wave since its sine was 0 and rising.
double Waveform::half_periods(double time) const { return 2 * (frequency * time + phase / 360); }

double Waveform::at(double time, bool after) const {
  if (shape == Shape::points) return polygon(time, after);
  if (shape == Shape::sine)
    return offset + amplitude * std::sin(2 * std::numbers::pi * (frequency * time + phase / 360));
  const double halves = half_periods(time), nearest = std::round(halves);
  const bool at_jump = std::abs(halves - nearest) < rounding_of_half_periods(halves);
  const double number = at_jump ? (after ? nearest : nearest - 1) : std::floor(halves);
  return std::fmod(number, 2) == 0 ? offset + amplitude : offset - amplitude;
}

double Waveform::integral(double from, double to) const {
  if (shape == Shape::sine) {
    const double rate = 2 * std::numbers::pi * frequency, shift = 2 * std::numbers::pi * phase / 360;
    // cos a - cos b as a product, which keeps its digits for short intervals
    const double middle = 0.5 * rate * (from + to) + shift, half = 0.5 * rate * (to - from);
    return offset * (to - from) + amplitude / rate * 2 * std::sin(middle) * std::sin(half);
  }
  double sum = 0;
  for (double start = from; start < to;) {
    const double end = std::min(to, next_corner(start));
    sum += 0.5 * (end - start) * (at(start, true) + at(end, false));
    start = end;
  }
  return sum;
}

double Waveform::next_corner(double time) const {
  if (shape == Shape::sine) return infinite;
  if (shape == Shape::points) {
    const auto next = std::ranges::upper_bound(points, time + rounding_of_time_at(time), {}, &Vec2::x);
    return next == points.end() ? infinite : next->x;
  }
  const double halves = half_periods(time), number = std::floor(halves + rounding_of_half_periods(halves)) + 1;
  return (0.5 * number - phase / 360) / frequency;
}

double Waveform::longest_step() const {
  constexpr double steps_in_period = 20;
  return shape == Shape::sine ? 1 / (steps_in_period * frequency) : infinite;
}

double Waveform::largest() const {
  double largest = std::abs(offset) + std::abs(amplitude);
  for (const Vec2 point : points) largest = std::max(largest, std::abs(point.y));
  return largest;
}

std::string Waveform::fault() const {
  if (shape != Shape::points && !(frequency > 0)) return "its frequency must be greater than 0 Hz";
  if (shape != Shape::points) return std::abs(phase) <= 360 ? "" : "its phase must be from -360 to 360 degrees";
  if (points.size() < 2) return fmt::format("it has {} points, and at least 2 are needed", points.size());
  for (std::size_t k = 1; k < points.size(); ++k) {
    if (points[k].x < points[k - 1].x)
      return fmt::format("the time {:g} s of point {} is before {:g} s of the point before: times must ascend",
                         points[k].x, k + 1, points[k - 1].x);
    if (k > 1 && points[k].x == points[k - 2].x)
      return fmt::format("three points have the time {:g} s: at most two may, which make a jump", points[k].x);
  }
  if (points.front().x == points.back().x) return "all its points have one time";
  return "";
}

Signal::Signal(Waveform given) : waveform(std::make_shared<const Waveform>(std::move(given))) {
  if (waveform->fault().empty()) value = waveform->at(0, true);
}

double Signal::next_corner(double time) const { return waveform ? waveform->next_corner(time) : infinite; }
double Signal::longest_step() const { return waveform ? waveform->longest_step() : infinite; }
double Signal::largest() const { return waveform ? waveform->largest() : std::abs(value); }

std::vector<Vec2> read_points(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(fmt::format("there is no table \"{}\"", path));
  std::ifstream file(path);
  std::vector<Vec2> points;
  std::string line;
  constexpr std::size_t most = 100'000;
  for (int number = 1; std::getline(file, line); ++number) {
    line = line.substr(0, line.find('#'));
    const bool blank = std::ranges::all_of(line, [](unsigned char c) { return std::isspace(c); });
    if (blank) continue;
    std::ranges::replace_if(
        line, [](char c) { return c == ',' || c == ';'; }, ' ');
    std::istringstream words(line);
    std::string first, second, rest;
    words >> first >> second;
    const bool whole = !second.empty() && !(words >> rest);
    const auto value_of = [](const std::string& word) {
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      return end == word.c_str() + word.size() && std::isfinite(value) ? value : NAN;
    };
    const Vec2 point = whole ? Vec2{value_of(first), value_of(second)} : Vec2{NAN, NAN};
    if (std::isnan(point.x) && points.empty() && std::isalpha(static_cast<unsigned char>(first.front())))
      continue;  // a header
    if (std::isnan(point.x) || std::isnan(point.y))
      throw InputError(
          fmt::format("{}:{}: this line of the table is not two finite numbers, time and value", path, number));
    points.push_back(point);
    if (points.size() > most) throw InputError(fmt::format("{}: a table of at most {} points is allowed", path, most));
  }
  return points;
}

}  // namespace lichtenberg
