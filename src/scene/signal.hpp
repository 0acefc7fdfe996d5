#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Potential (V) or current (A) of a source as a function of time: a polygon through points, a sine or a square wave.
struct Waveform {
  enum class Shape { points, sine, square };
  Shape shape = Shape::points;
  /// Points (s, V or A) in ascending order of time. Two points of one time are a jump. The first and the last value
  /// hold beyond the ends.
  std::vector<Vec2> points{};
  bool covers_run = false;  ///< true: a table, which must cover the whole run; false: its ends hold
  /// offset + amplitude * sin(2 pi frequency t + phase), or for a square wave the sign of this sine
  double amplitude = 0, frequency = 0, offset = 0;
  double phase = 0;  ///< degrees

  /// Returns the value at `time` (s). `after`: the limit from later times at a jump, otherwise from earlier times.
  double at(double time, bool after) const;
  /// Returns the integral (V s, or C) from `from` to `to` (s); exact.
  double integral(double from, double to) const;
  /// Returns the first time (s) after `time` at which the value or its slope jumps; infinite if there is none.
  double next_corner(double time) const;
  /// Returns the longest time step (s) that resolves the waveform between corners: 1/20 of the period of a sine,
  /// otherwise infinity.
  double longest_step() const;
  /// Returns the largest magnitude of the value at any time.
  double largest() const;
  /// Describes a fault of the points or the frequency; empty if the waveform is valid.
  std::string fault() const;
  bool operator==(const Waveform&) const = default;

 private:
  double polygon(double time, bool after) const;
  double half_periods(double time) const;
};

/// Potential or current of a source: a constant, or a function of time. Two signals are equal if they have the same
/// value at all times by their definition.
struct Signal {
  double value = 0;                            ///< V or A: the constant, or the value at time 0
  std::shared_ptr<const Waveform> waveform{};  ///< null: constant

  Signal(double constant = 0) : value(constant) {}
  explicit Signal(Waveform given);

  bool varies() const { return waveform != nullptr; }
  /// Returns true if the value is constant after `time` (s).
  bool is_constant_after(double time) const {
    return !waveform || (waveform->shape == Waveform::Shape::points && waveform->next_corner(time) == INFINITY);
  }
  double at(double time, bool after) const { return waveform ? waveform->at(time, after) : value; }
  double integral(double from, double to) const {
    return waveform ? waveform->integral(from, to) : value * (to - from);
  }
  double next_corner(double time) const;
  double longest_step() const;
  double largest() const;
  friend bool operator==(const Signal& a, const Signal& b) {
    return a.value == b.value && (a.waveform == b.waveform || (a.waveform && b.waveform && *a.waveform == *b.waveform));
  }
};

/// Reads the points (s, V or A) of a table from a CSV file: two numbers a line, separated by a comma, a semicolon or
/// blanks. A first line without numbers is a header; "#" begins a comment. Throws InputError, with file and line, for a
/// file that cannot be read, a line that is not two numbers, or more than 100000 points.
std::vector<Vec2> read_points(const std::string& path);

}  // namespace lichtenberg
