#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "src/analysis/network.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {

/// How long something takes, for people: "4.2 s", "3 min 20 s", "2 h 5 min".
std::string duration(double seconds);

/// The line that says how far a run is, on standard error: redrawn in place on a terminal, now and then elsewhere.
class Progress {
 public:
  /// Times in s: where this program starts, where the run stops at the latest.
  Progress(double start, double stop, bool quiet);
  ~Progress() { end_line(); }
  Progress(const Progress&) = delete;

  void show(const Frame& frame, const std::optional<analysis::Network>& network);
  /// Whether it is time for another line, and that line.
  bool due() const;
  void show(const std::string& line);
  /// Before anything else is printed: it would run into the line.
  void end_line();

 private:
  using Clock = std::chrono::steady_clock;
  std::string line(const Frame& frame, const std::optional<analysis::Network>& network) const;

  double start_, stop_;
  bool quiet_, terminal_;
  bool unfinished_line_ = false;
  Clock::time_point began_ = Clock::now();
  std::optional<Clock::time_point> shown_;
};

}  // namespace lichtenberg
