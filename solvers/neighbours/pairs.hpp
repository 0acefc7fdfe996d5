#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg {

/// Pair of particles, i < j.
struct Pair {
  int i = 0, j = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Disks (d = 2) or spheres (d = 3) in plain arrays, in a box of which only the periodic axes matter here. Positions
/// need not lie inside a periodic box: any image of a particle may be given.
template <int d>
struct Spheres {
  std::span<const double> position;  ///< Positions (m), [N * d]
  std::span<const double> radius;    ///< Radii (m), [N]
  Box<d> box{};
  std::span<const double> charge{};  ///< Charges (C), [N]; empty: none

  int size() const { return static_cast<int>(radius.size()); }
  LICHTENBERG_HOST_DEVICE Vec<d> centre(int i) const {
    Vec<d> p;
    for (int k = 0; k < d; ++k) p[k] = position[i * d + k];
    return p;
  }
};

/// Returns all pairs with a surface distance below `range` (m; overlapping ones included), in ascending order for any
/// number of threads. The work grows with the numbers of particles and pairs, since particles are sorted into cells.
/// Throws InputError if a periodic box is so short that two images of one particle could be within range of another.
template <int d>
std::vector<Pair> pairs_closer_than(const Spheres<d>& spheres, double range,
                                    parallel::Team& team = parallel::Team::single());

/// Returns all pairs with a surface distance of nearest images below `range` plus both particles' reaches (m, [N], not
/// negative). Order, work and errors are those of pairs_closer_than. The cost of a particle with a long reach is
/// proportional to the number of particles within that reach.
template <int d>
std::vector<Pair> pairs_within_reach(const Spheres<d>& spheres, double range, std::span<const double> reach,
                                     parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg
