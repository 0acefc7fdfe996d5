// Measures seconds and memory of add() and save() for frames of many particles, from the first to the last frame.
//
//   build/benchmark_record --particles 1000000 --frames 100 --folder /scratch
#include <fmt/format.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>

#include "src/record/recorder.hpp"
#include "validation/benchmarks/machine.hpp"

using namespace lichtenberg;
namespace fs = std::filesystem;
using Of = Column::Of;

namespace {

struct Cost {
  double seconds = 0, processor = 0;  ///< wall and processor time
  double resident = 0, largest = 0;   ///< MB, after and during the call
};

/// Returns a value (MB) of /proc/self/status.
double status(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key)) return std::stod(line.substr(line.find(':') + 1)) / 1024;
  return 0;
}

void forget_largest() { std::ofstream("/proc/self/clear_refs") << 5; }

template <class Work>
Cost cost_of(Work work) {
  forget_largest();
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t started = std::clock();
  work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  const double processor = static_cast<double>(std::clock() - started) / CLOCKS_PER_SEC;
  return {elapsed.count(), processor, status("VmRSS"), status("VmHWM")};
}

/// Data of the caller, which continues computing with it.
struct Gas {
  std::vector<double> position, velocity, charge;
  std::vector<std::int32_t> contacts;

  explicit Gas(std::size_t particles) : charge(particles), contacts(6 * particles) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> number;
    for (std::vector<double>* each : {&position, &velocity})
      for (std::size_t k = 0; k < 3 * particles; ++k) each->push_back(number(random));
    for (double& each : charge) each = number(random);
    for (std::int32_t& each : contacts) each = static_cast<std::int32_t>(random() % particles);
  }
  Frame frame(double time) const {
    return {.time = time,
            .columns = {{"position", "m", Of::particles, 3, position},
                        {"velocity", "m s-1", Of::particles, 3, velocity},
                        {"charge", "C", Of::particles, 0, charge},
                        {"energy", "J", Of::system, 0, std::vector<double>{time}},
                        {"contacts", "1", Of::list, 2, contacts}}};
  }
};

double mean(const std::vector<Cost>& costs, double Cost::*number, std::size_t first, std::size_t count) {
  double sum = 0;
  for (std::size_t k = first; k < first + count; ++k) sum += costs[k].*number;
  return sum / static_cast<double>(count);
}

void print(const std::vector<Cost>& costs, const Cost& end, double before, double frame_bytes) {
  const std::size_t tenth = std::max<std::size_t>(costs.size() / 10, 1), last = costs.size() - tenth;
  fmt::print("{:14} {:>12} {:>12} {:>14} {:>14}\n", "frames", "s a frame", "processor s", "resident (MB)",
             "largest (MB)");
  for (std::size_t k = 0; k + tenth <= costs.size(); k += tenth)
    fmt::print("{:<4} to {:<6} {:12.3f} {:12.3f} {:14.0f} {:14.0f}\n", k, k + tenth - 1,
               mean(costs, &Cost::seconds, k, tenth), mean(costs, &Cost::processor, k, tenth),
               mean(costs, &Cost::resident, k, tenth), mean(costs, &Cost::largest, k, tenth));
  const auto ratio = [&](double Cost::*number) {
    return mean(costs, number, last, tenth) / mean(costs, number, 0, tenth);
  };
  double largest = 0;
  for (const Cost& cost : costs) largest = std::max(largest, cost.largest);
  fmt::print("last tenth over first: {:.3f} in seconds, {:.3f} of the processor, {:.3f} in memory\n",
             ratio(&Cost::seconds), ratio(&Cost::processor), ratio(&Cost::resident));
  fmt::print("largest above the caller's own {:.0f} MB: {:.2f} frames of {:.0f} MB\n", before,
             (largest - before) * 1048576 / frame_bytes, frame_bytes / 1048576);
  fmt::print("the end: {:.1f} s, {:.1f} of the processor, {:.2f} frames above the caller's own\n", end.seconds,
             end.processor, (end.largest - before) * 1048576 / frame_bytes);
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t particles = 1000000;
  int frames = 100;
  std::string folder = ".";
  CLI::App program("What a frame costs to record");
  program.add_option("--particles", particles);
  program.add_option("--frames", frames);
  program.add_option("--folder", folder, "where the result is written, and removed");
  CLI11_PARSE(program, argc, argv);
  fmt::print("{}\n", benchmarks::machine());

  const std::string path = (fs::path(folder) / "benchmark_record.h5").string();
  const Gas gas(particles);
  Scene scene;
  scene.domain.size = {1, 1};
  Milestone milestone;
  milestone.checkpoint.reals = {{"position", gas.position}, {"velocity", gas.velocity}};
  double frame_bytes = 0;
  for (const Column& column : gas.frame(0).columns) frame_bytes += static_cast<double>(column.bytes());

  Recorder recorder = Recorder::start(path, scene, std::vector<double>(particles, 1.0), true);
  std::vector<Cost> costs;
  const double before = status("VmRSS");
  for (int k = 0; k < frames; ++k) {
    Frame frame = gas.frame(k);  // not timed; the caller makes it
    costs.push_back(cost_of([&] {
      recorder.add(std::move(frame));
      recorder.save(milestone);
    }));
  }
  milestone.summary = {{"energy", 1, "J"}};
  const Cost end = cost_of([&] { recorder.save(milestone); });
  print(costs, end, before, frame_bytes);
  fs::remove(path);
  return 0;
}
