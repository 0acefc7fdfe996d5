#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg {

/// Pair of particles, by their indices i < j.
struct Pair {
  int i = 0, j = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// View of disks (d = 2) or spheres (d = 3) for pair searches: arrays of positions, radii and charges, and the box.
/// Pair searches use only the periodic axes of the box. Positions may be outside a periodic box: any periodic image of
/// a particle is allowed.
template <int d>
struct Spheres {
  std::span<const double> position;  ///< Positions (m), [N * d]
  std::span<const double> radius;    ///< Radii (m), [N]
  Box<d> box{};
  std::span<const double> charge{};  ///< Charges (C), [N]; empty: none

  /// Returns the number of particles.
  int size() const { return static_cast<int>(radius.size()); }
  /// Returns the position (m) of particle i.
  LICHTENBERG_HOST_DEVICE Vec<d> centre(int i) const {
    Vec<d> p;
    for (int k = 0; k < d; ++k) p[k] = position[i * d + k];
    return p;
  }
};

/// Finds all pairs of particles with a surface distance (gap of nearest images) below `range` (m), including
/// overlapping pairs. Returns them in ascending order, for any number of threads of `team`. A cell list limits the
/// comparisons to particles in nearby cells. Throws InputError if a periodic box is so short that two images of a
/// particle could be within range of another one.
template <int d>
std::vector<Pair> pairs_closer_than(const Spheres<d>& spheres, double range,
                                    parallel::Team& team = parallel::Team::single());

/// Finds all pairs of particles with a surface distance (gap of nearest images) below range + reach[i] + reach[j].
/// `reach` (m, [N], not negative) is an extra range per particle, such as the distance it moves in a time step. Order
/// and errors are those of pairs_closer_than. A long reach of one particle does not extend the searches of the others.
template <int d>
std::vector<Pair> pairs_within_reach(const Spheres<d>& spheres, double range, std::span<const double> reach,
                                     parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg
