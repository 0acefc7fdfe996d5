#pragma once

#include <cstdint>
#include <random>

#include "solvers/laplace/problem.hpp"

/// Disks at random places, for the field solvers' tests.
namespace lichtenberg::crowds {

/// Uniform numbers, the same on every machine.
struct Random {
  std::mt19937_64 generator;
  explicit Random(std::uint64_t seed) : generator(seed) {}
  double operator()(double from, double to) {
    return from + (to - from) * static_cast<double>(generator() >> 11) * 0x1p-53;
  }
};

/// Adds the disk as a group of its own, with a charge between -1 and 1, if it keeps `least_gap` from all bodies.
inline void add_if_free(laplace::LaplaceProblem& problem, const Disk& disk, double least_gap, Random& random) {
  for (const laplace::Body& body : problem.bodies)
    if (gap(disk, body.shape) <= least_gap) return;
  problem.bodies.push_back({disk, static_cast<int>(problem.groups.size())});
  problem.groups.push_back({true, random(-1, 1), 0});
}

}  // namespace lichtenberg::crowds
