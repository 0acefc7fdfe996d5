#include "src/commands/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

namespace lichtenberg {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds between_redraws{0.1};
constexpr Seconds between_lines{30};  // where lines pile up: a log file

}  // namespace

std::string duration(double seconds) {
  if (seconds < 60) return fmt::format("{:.2g} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(double start, double stop, bool quiet)
    : start_(start), stop_(stop), quiet_(quiet), terminal_(isatty(STDERR_FILENO)) {}

void Progress::end_line() {
  if (std::exchange(unfinished_line_, false)) fmt::print(stderr, "\n");
}

bool Progress::due() const {
  return !quiet_ && !(shown_ && Clock::now() - *shown_ < (terminal_ ? between_redraws : between_lines));
}

void Progress::show(std::string line, double now) {
  shown_ = Clock::now();
  if (now > start_ && std::isfinite(stop_)) {
    const double elapsed = Seconds(Clock::now() - began_).count();
    line += fmt::format(", at most {} left", duration(elapsed * (stop_ - now) / (now - start_)));
  }
  if (terminal_)
    fmt::print(stderr, "\r{}\033[K", line);  // \033[K clears what is left of a longer line
  else
    fmt::print(stderr, "{}\n", line);
  unfinished_line_ = terminal_;
}

}  // namespace lichtenberg
