#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>

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

/// How far the process's memory rises above what it has now, on Linux.
class MemoryPeak {
 public:
  MemoryPeak() {
    malloc_trim(0);                               // what earlier candidates freed must not hide what this one takes
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

/// How many runs to take the median of, for one that takes `seconds`.
int repeats(double seconds) {
  constexpr int most = 5;
  constexpr double enough = 2;  // s, for all of them
  return std::clamp(static_cast<int>(enough / seconds), 1, most);
}

/// A first run that takes this long is long enough for what it allocates not to matter, and counts itself.
constexpr double long_run = 2;  // s

Point measure(const std::string& method, const Candidate& candidate) {
  Point point{.method = method, .settings = candidate.settings};
  const MemoryPeak memory;
  const std::unique_ptr<Trial> trial = candidate.make();
  std::vector<double> wall, processor;
  const auto run = [&] {
    const double wall_start = wall_seconds(), processor_start = processor_seconds();
    trial->run();
    const std::optional<double> own = trial->own_seconds();
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
  if (!trial->is_elsewhere()) point.mebibytes = memory.mebibytes();
  return point;
}

/// What to expect of a method's next candidate, from the last one that was tried.
struct Experience {
  double seconds = 0, cost = 0;
  double expected(double next) const { return cost > 0 ? seconds * next / cost : 0; }
};

bool all_finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

void try_candidate(const std::string& method, const Candidate& candidate, double budget, Experience& experience,
                   Diagram& diagram) {
  const auto leave_out = [&](const std::string& reason) {
    diagram.left_out.push_back({method, candidate.settings, reason});
  };
  if (experience.expected(candidate.cost) > budget)
    return leave_out(fmt::format("expected to take longer than {:g} s", budget));
  const double start = wall_seconds();
  try {
    Point point = measure(method, candidate);
    experience = {point.seconds, candidate.cost};
    if (!all_finite(point.errors)) return leave_out("unstable");
    diagram.points.push_back(std::move(point));
  } catch (const InputError& error) {
    leave_out(error.what());
  } catch (const Failure& failure) {
    experience = {wall_seconds() - start, candidate.cost};
    leave_out(failure.what());
  }
}

}  // namespace

double seconds_of_thread() { return seconds_by(CLOCK_THREAD_CPUTIME_ID); }

std::string to_string(const Settings& settings) {
  std::string text;
  for (const auto& [name, value] : settings) text += fmt::format("{}{} = {:g}", text.empty() ? "" : ", ", name, value);
  return text;
}

std::vector<Method> choose(std::vector<Method> all, const std::vector<std::string>& names) {
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const Method& method : all) known.push_back(method.name);
  for (const std::string& name : names)
    if (std::ranges::find(known, name) == known.end())
      throw InputError(fmt::format("--methods {}: there is no such method; did you mean {}? Allowed are {}", name,
                                   nearest(name, known), fmt::join(known, ", ")));
  std::erase_if(all, [&](const Method& method) { return std::ranges::find(names, method.name) == names.end(); });
  return all;
}

void measure(const std::vector<Method>& methods, const Request& request, Diagram& diagram) {
  int all = 0, place = 0;
  for (const Method& method : methods) all += static_cast<int>(method.candidates.size());
  for (const Method& method : methods) {
    diagram.methods.emplace_back(method.name, method.description);
    Experience experience;
    for (const Candidate& candidate : method.candidates) {
      if (request.progress) request.progress(++place, all, method.name, candidate.settings);
      try_candidate(method.name, candidate, request.seconds, experience, diagram);
    }
  }
}

std::vector<Price> price_list(const Diagram& diagram, std::size_t quantity) {
  constexpr int last = std::numeric_limits<double>::digits10 + 1;  // or errors of 0 would go on for ever
  std::vector<Price> prices;
  for (int decade = 1; decade <= last && (prices.empty() || prices.back().point != nullptr); ++decade) {
    Price price{.error = std::pow(10.0, -decade)};
    for (const Point& point : diagram.points) {
      const double own = std::max(point.errors[quantity], diagram.reference_errors[quantity]);
      if (own <= price.error && (price.point == nullptr || point.seconds < price.point->seconds)) price.point = &point;
    }
    prices.push_back(price);
  }
  return prices;
}

}  // namespace lichtenberg::work_precision
