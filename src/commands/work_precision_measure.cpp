#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "solvers/error.hpp"
#include "src/commands/work_precision.hpp"
#include "src/scene/nearest.hpp"

namespace lichtenberg::work_precision {
namespace {

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double seconds_by(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double processor_seconds() { return seconds_by(CLOCK_PROCESS_CPUTIME_ID); }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Rise of the process's memory above its value at construction, on Linux.
class MemoryPeak {
 public:
  MemoryPeak() {
    malloc_trim(0);                               // memory freed by earlier candidates must not hide that of this one
    std::ofstream("/proc/self/clear_refs") << 5;  // resets VmHWM
    start_ = kibibytes("VmRSS:");
  }
  std::optional<double> mebibytes() const {
    const std::optional<double> peak = kibibytes("VmHWM:");
    if (!start_ || !peak) return {};
    return std::max(0.0, *peak - *start_) / 1024;
  }

 private:
  static std::optional<double> kibibytes(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string word; file >> word;)
      if (double value = 0; word == name && file >> value) return value;
    return {};
  }
  std::optional<double> start_;
};

/// Returns the number of runs for the median, for a run of `seconds`.
int repeats(double seconds) {
  constexpr int most = 5;
  constexpr double enough = 2;  // s, for all of them
  return std::clamp(static_cast<int>(enough / seconds), 1, most);
}

/// The first run counts itself if it takes this long, because the cost of allocation is negligible then.
constexpr double long_run = 2;  // s

}  // namespace

Point measure(const Candidate& candidate) {
  Point point;
  const MemoryPeak memory;
  const std::unique_ptr<Trial> trial = candidate.make();
  std::vector<double> wall, processor;
  const auto run = [&] {
    const double wall_start = wall_seconds(), processor_start = processor_seconds();
    trial->run();
    const std::optional<double> own = trial->measured_seconds();
    wall.push_back(own.value_or(wall_seconds() - wall_start));
    processor.push_back(own.value_or(processor_seconds() - processor_start));
  };
  run();
  if (wall.front() < long_run) {
    const int count = repeats(wall.front());
    wall.clear();
    processor.clear();
    for (int k = 0; k < count; ++k) run();
  }
  point.seconds = median(wall);
  point.cores = median(processor) / point.seconds;
  point.errors = trial->errors();
  point.work = trial->work();
  point.evaluations = trial->evaluations();
  if (!trial->uses_other_memory()) point.mebibytes = memory.mebibytes();
  return point;
}

double seconds_of_thread() { return seconds_by(CLOCK_THREAD_CPUTIME_ID); }

std::vector<Method> choose(std::vector<Method> all, const Request& request) {
  if (request.methods.empty()) return all;
  std::vector<std::string> known;
  for (const Method& method : all) known.push_back(method.name);
  known.insert(known.end(), request.others.begin(), request.others.end());
  for (const std::string& name : request.methods)
    if (std::ranges::find(known, name) == known.end())
      throw InputError(fmt::format("--methods {}: there is no such method; did you mean {}? Allowed are {}", name,
                                   nearest(name, known), fmt::join(known, ", ")));
  std::erase_if(all, [&](const Method& method) {
    return std::ranges::find(request.methods, method.name) == request.methods.end();
  });
  return all;
}

}  // namespace lichtenberg::work_precision
