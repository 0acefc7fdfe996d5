#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace lichtenberg {

/// Seconds that are left of a run of which the share `done` has taken `seconds` in all and `recent` of it, its last
/// part, `recent_seconds`: at the pace of that part. None before a tenth is done, or if the pace since the start says
/// otherwise by more than a factor of two: then no pace holds.
std::optional<double> seconds_left(double done, double seconds, double recent, double recent_seconds);

/// How long something takes, for people: "4.2 s", "3 min 20 s", "2 h 5 min".
std::string duration(double seconds);

/// The line that says how far a run is, on standard error: redrawn in place on a terminal, now and then elsewhere.
class Progress {
 public:
  /// Where this program starts and where the run ends (infinite: nobody knows), in a measure that grows at a steady
  /// pace; `may_end_before`: another condition may end it earlier.
  Progress(double start, double stop, bool quiet, bool may_end_before = false);
  ~Progress() { end_line(); }
  Progress(const Progress&) = delete;

  /// Whether it is time for another line.
  bool due() const;
  /// Shows a line, with how long it takes from `now` to the end, at most if it may end before, if a tenth is done and
  /// the pace tells.
  void show(std::string line, double now);
  /// Before anything else is printed: it would run into the line.
  void end_line();

 private:
  std::string time_left(double now);
  using Clock = std::chrono::steady_clock;

  double start_, stop_;
  bool quiet_, may_end_before_, terminal_;
  bool unfinished_line_ = false;
  struct Sample {
    double done, seconds;  ///< share of the run, time since the start
  };
  std::vector<Sample> samples_;
  Clock::time_point began_ = Clock::now();
  std::optional<Clock::time_point> shown_;
};

}  // namespace lichtenberg
