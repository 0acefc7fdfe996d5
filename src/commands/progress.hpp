#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace lichtenberg {

/// How long something takes, for people: "4.2 s", "3 min 20 s", "2 h 5 min".
std::string duration(double seconds);

/// The line that says how far a run is, on standard error: redrawn in place on a terminal, now and then elsewhere.
class Progress {
 public:
  /// Times of the run: where this program starts, where the run ends at the latest (infinite: nobody knows).
  Progress(double start, double stop, bool quiet);
  ~Progress() { end_line(); }
  Progress(const Progress&) = delete;

  /// Whether it is time for another line.
  bool due() const;
  /// Shows a line, with how long it may take from `now` to the end added if that is known.
  void show(std::string line, double now);
  /// Before anything else is printed: it would run into the line.
  void end_line();

 private:
  using Clock = std::chrono::steady_clock;

  double start_, stop_;
  bool quiet_, terminal_;
  bool unfinished_line_ = false;
  Clock::time_point began_ = Clock::now();
  std::optional<Clock::time_point> shown_;
};

}  // namespace lichtenberg
