// Times neighbour search of grains in a periodic cube or square: list rebuild, check of list validity, pairs per
// second.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>

#include "solvers/neighbours/list.hpp"
#include "validation/benchmarks/machine.hpp"

using namespace lichtenberg;

namespace {

struct Options {
  std::vector<int> sizes{10000, 100000, 1000000};
  std::vector<int> threads{1, 2};
  double density = 0.1458;  // grains of diameter 1 per unit volume, as in G's gas
  double neighbours = 6;    // per grain
  int repeats = 3;
};

/// Minimum of several runs: wall time, and processor time of all threads.
struct Seconds {
  double wall = INFINITY, processors = INFINITY;
};

Seconds seconds(const auto& work, int repeats) {
  Seconds least;
  for (int k = 0; k < repeats; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t before = std::clock();
    work();
    least.processors = std::min(least.processors, static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    least.wall = std::min(least.wall, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

/// Times grains at random positions in random memory order.
template <int d>
void measure(int count, int threads, const Options& options) {
  constexpr double diameter = 1, ball = d == 3 ? 4.0 / 3 * M_PI : M_PI;
  const double length = std::pow(count / options.density, 1.0 / d);
  const double within = std::pow(options.neighbours / (options.density * ball), 1.0 / d);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(0, length);
  std::vector<double> position(static_cast<std::size_t>(count) * d), radius(count, 0.5 * diameter);
  for (double& x : position) x = coordinate(random);
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = length;
  box.sides.fill(Boundary::periodic);
  const Spheres<d> grains{position, radius, box};
  parallel::Team team(threads);
  NeighbourList list(0, within - diameter);
  const Seconds search = seconds([&] { list.search(grains, team); }, options.repeats);
  const Seconds check = seconds([&] { list.update(grains, team); }, options.repeats);
  fmt::print("{:>10}{:>4}{:>9}{:>12}{:>12.1f}{:>12.1f}{:>14.2e}{:>12.2f}\n", count, d, threads, list.pairs().size(),
             1e3 * search.wall, 1e3 * search.processors, static_cast<double>(list.pairs().size()) / search.processors,
             1e3 * check.processors);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App program("Searches for neighbours, timed.");
  program.add_option("--sizes", options.sizes)->delimiter(',');
  program.add_option("--threads", options.threads)->delimiter(',');
  program.add_option("--density", options.density, "grains in the cube of a diameter");
  program.add_option("--neighbours", options.neighbours, "of a grain");
  program.add_option("--repeats", options.repeats);
  CLI11_PARSE(program, argc, argv);
  fmt::print("{}\n", benchmarks::machine());
  fmt::print("{:>10}{:>4}{:>9}{:>12}{:>12}{:>12}{:>14}{:>12}\n", "grains", "d", "threads", "pairs", "search ms",
             "CPU ms", "pairs/CPU s", "check ms");
  for (const int count : options.sizes)
    for (const int threads : options.threads) {
      measure<3>(count, threads, options);
      measure<2>(count, threads, options);
    }
}
