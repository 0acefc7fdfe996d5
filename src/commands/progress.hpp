#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace lichtenberg {

/// Estimates the remaining time (s) of a run at its recent pace. `done`: completed fraction, which took `seconds`; its
/// last part `recent` took `recent_seconds`. Empty before 10 % are done, or if the mean pace differs from the recent
/// one by more than a factor of two.
std::optional<double> seconds_left(double done, double seconds, double recent, double recent_seconds);

/// Formats a duration (s) as text: "4.2 s", "3 min 20 s", "2 h 5 min".
std::string duration(double seconds);

/// Progress line of a run on standard error: redrawn in place on a terminal, otherwise printed at most every 30 s.
class Progress {
 public:
  /// Prepares the line. `start`, `stop`: start of this session and end of the run in a measure that grows at a steady
  /// pace; infinite: unknown. `quiet`: true if due() is always false. `may_end_before`: true if another condition may
  /// end the run earlier.
  Progress(double start, double stop, bool quiet, bool may_end_before = false);
  ~Progress() { end_line(); }
  Progress(const Progress&) = delete;

  /// Returns true if another line is due.
  bool due() const;
  /// Prints a line with the remaining time from `now` to the end, or an upper bound if the run may end earlier. Omits
  /// the time if seconds_left() gives none or the end is unknown.
  void show(std::string line, double now);
  /// Ends the unfinished line. Call it before anything else is printed.
  void end_line();

 private:
  std::string time_left(double now);
  using Clock = std::chrono::steady_clock;

  double start_, stop_;
  bool quiet_, may_end_before_, terminal_;
  bool unfinished_line_ = false;
  struct Sample {
    double done, seconds;  ///< fraction of the run; seconds since the start
  };
  std::vector<Sample> samples_;
  Clock::time_point began_ = Clock::now();
  std::optional<Clock::time_point> shown_;
};

}  // namespace lichtenberg
