#include "src/commands/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace lichtenberg {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds between_redraws{0.1};
constexpr Seconds between_lines{30};  // if lines accumulate, as in a log file

}  // namespace

std::string duration(double seconds) {
  if (seconds < 60) return fmt::format("{:.2g} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(double start, double stop, bool quiet, bool may_end_before)
    : start_(start), stop_(stop), quiet_(quiet), may_end_before_(may_end_before), terminal_(isatty(STDERR_FILENO)) {}

void Progress::end_line() {
  if (std::exchange(unfinished_line_, false)) fmt::print(stderr, "\n");
}

bool Progress::due() const {
  return !quiet_ && !(shown_ && Clock::now() - *shown_ < (terminal_ ? between_redraws : between_lines));
}

std::optional<double> seconds_left(double done, double seconds, double recent, double recent_seconds) {
  constexpr double least = 0.1, factor = 2;
  if (done < least || recent <= 0) return {};
  const double mean = seconds * (1 - done) / done, now = recent_seconds * (1 - done) / recent;
  if (now > factor * mean || mean > factor * now) return {};
  return now;
}

/// Returns the text for the remaining time. The recent pace is that of the last third of the completed work.
std::string Progress::time_left(double now) {
  const double done = (now - start_) / (stop_ - start_), seconds = Seconds(Clock::now() - began_).count();
  samples_.push_back({done, seconds});
  const auto since = std::ranges::find_if(samples_, [&](const Sample& s) { return s.done >= 2.0 / 3 * done; });
  const auto left = seconds_left(done, seconds, done - since->done, seconds - since->seconds);
  return left ? fmt::format(", {}about {} left", may_end_before_ ? "at most " : "", duration(*left)) : "";
}

void Progress::show(std::string line, double now) {
  shown_ = Clock::now();
  if (now > start_ && std::isfinite(stop_)) line += time_left(now);
  if (terminal_)
    fmt::print(stderr, "\r{}\033[K", line);  // \033[K clears the rest of a longer line
  else
    fmt::print(stderr, "{}\n", line);
  unfinished_line_ = terminal_;
}

}  // namespace lichtenberg
