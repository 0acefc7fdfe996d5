#pragma once

#include <cstdint>
#include <random>

#include "solvers/laplace/problem.hpp"

/// Disks at random positions for tests of the field solvers.
namespace lichtenberg::random_placement {

/// Uniform random numbers, identical on every machine.
struct Random {
  std::mt19937_64 generator;
  explicit Random(std::uint64_t seed) : generator(seed) {}
  double operator()(double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  }
};

/// Adds the disk as its own group, with a charge between -1 and 1, if its gap to all bodies exceeds `least_gap`.
inline void add_if_free(laplace::LaplaceProblem& problem, const Disk& disk, double least_gap, Random& random) {
  for (const laplace::Body& body : problem.bodies)
    if (gap(disk, body.shape) <= least_gap) return;
  problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
  problem.groups.push_back({true, random(-1, 1), 0});
}

}  // namespace lichtenberg::random_placement
