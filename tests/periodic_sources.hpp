#pragma once

#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/ewald.hpp"

namespace lichtenberg::periodic {

/// Sources that can be moved and changed.
struct SourceSet {
  Vec3 lengths{1, 1, 1};
  std::vector<double> position, charge, dipole{};

  operator Sources() const { return {lengths, position, charge, dipole}; }
  int size() const { return static_cast<int>(charge.size()); }
};

inline Response evaluated(Sum& sum, const SourceSet& sources, parallel::Team& team = parallel::Team::single()) {
  Response response;
  sum.evaluate(sources, {}, team, response);
  return response;
}
/// Pairs of sources whose nearest images are less than `within` apart.
inline std::vector<Pair> pairs_of(const SourceSet& sources, double within) {
  Box<3> box{sources.lengths};
  box.sides.fill(Boundary::periodic);
  const std::vector<double> radius(sources.size());
  return pairs_closer_than(Spheres<3>{sources.position, radius, box}, within);
}
/// Evaluates a sum that needs pairs; `skin` adds pairs beyond the cutoff.
inline Response evaluated_on(Sum& sum, const SourceSet& sources, double skin = 0,
                             parallel::Team& team = parallel::Team::single()) {
  const auto pairs = pairs_of(sources, sum.cutoff() + skin);
  Response response;
  sum.evaluate(sources, pairs, team, response);
  return response;
}
inline Response by_ewald(const SourceSet& sources, double tolerance = 1e-14, double alpha = 0) {
  Ewald ewald(splitting_for(sources, tolerance, alpha));
  return evaluated(ewald, sources);
}

/// Sources at random positions, at least `least_distance` from each other, with charges (and dipoles, if any) up to 1
/// of both signs.
inline SourceSet random_sources(int n, Vec3 lengths, double least_distance, bool dipoles, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  SourceSet sources{.lengths = lengths};
  while (sources.size() < n) {
    const Vec3 position{unit(random) * lengths.x, unit(random) * lengths.y, unit(random) * lengths.z};
    bool free = true;
    for (int i = 0; i < sources.size() && free; ++i) {
      Vec3 r = Sources(sources).position_of(i) - position;
      for (int k = 0; k < 3; ++k) r[k] -= lengths[k] * std::nearbyint(r[k] / lengths[k]);
      free = norm(r) >= least_distance;
    }
    if (!free) continue;
    for (int k = 0; k < 3; ++k) sources.position.push_back(position[k]);
    sources.charge.push_back(2 * unit(random) - 1);
    for (int k = 0; k < (dipoles ? 3 : 0); ++k) sources.dipole.push_back(2 * unit(random) - 1);
  }
  return sources;
}

/// Cell of a cubic lattice with a source at each of `position` (in units of the side).
inline SourceSet lattice(double side, const std::vector<Vec3>& position, const std::vector<double>& charge) {
  SourceSet sources{.lengths = {side, side, side}, .charge = charge};
  for (const Vec3 p : position)
    for (int k = 0; k < 3; ++k) sources.position.push_back(side * p[k]);
  return sources;
}

/// Rock salt in a cell of edge 2, so that neighbours are at distance 1.
inline SourceSet rock_salt() {
  SourceSet sources{.lengths = {2, 2, 2}};
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    for (const int coordinate : {x, y, z}) sources.position.push_back(coordinate);
    sources.charge.push_back((x + y + z) % 2 == 0 ? 1 : -1);
  }
  return sources;
}

inline double largest(const std::vector<double>& v) {
  double result = 0;
  for (const double x : v) result = std::max(result, std::abs(x));
  return result;
}
inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) difference[k] = a[k] - b.at(k);
  return largest(difference);
}

/// Root mean square of the difference over that of `exact`; infinite for numbers of another count.
inline double relative_difference(std::span<const double> found, std::span<const double> exact) {
  if (found.size() != exact.size()) return INFINITY;
  double difference2 = 0, exact2 = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    difference2 += (found[k] - exact[k]) * (found[k] - exact[k]);
    exact2 += exact[k] * exact[k];
  }
  return std::sqrt(difference2 / exact2);
}

/// Derivative of the energy by the coordinate (or any other number) `x`, from fourth-order differences.
template <class Energy>
double energy_slope(double& x, double step, const Energy& energy) {
  const double at = x;
  const auto shifted = [&](double by) {
    x = at + by;
    return energy();
  };
  const double result = (8 * (shifted(step) - shifted(-step)) - (shifted(2 * step) - shifted(-2 * step))) / (12 * step);
  x = at;
  return result;
}

}  // namespace lichtenberg::periodic
