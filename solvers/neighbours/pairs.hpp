#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg {

/// Two particles, i < j.
struct Pair {
  int i = 0, j = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Disks (d = 2) or spheres (d = 3) on plain arrays, in a box of which only the periodic axes matter here. Places need
/// not lie inside a periodic box: any image of a particle stands for it.
template <int d>
struct Spheres {
  std::span<const double> position;  ///< m, [N * d]
  std::span<const double> radius;    ///< m, [N]
  Box<d> box{};
  std::span<const double> charge{};  ///< C, [N]; empty: none

  int size() const { return static_cast<int>(radius.size()); }
  LICHTENBERG_HOST_DEVICE Vec<d> place(int i) const {
    Vec<d> p;
    for (int k = 0; k < d; ++k) p[k] = position[i * d + k];
    return p;
  }
};

/// All pairs whose surfaces are closer than `range` (m; overlapping ones included), in ascending order, whatever the
/// number of threads. The work grows with the number of particles and of pairs: particles are sorted into cells that a
/// pair cannot reach across. Throws InputError if a periodic box is so short that two images of one particle could be
/// within range of another.
template <int d>
std::vector<Pair> pairs_closer_than(const Spheres<d>& spheres, double range,
                                    parallel::Team& team = parallel::Team::single());

/// All pairs whose surfaces are closer than `range` and both particles' reaches (m, [N], not negative) together,
/// nearest images counting; order, work and errors as for pairs_closer_than. One particle with a long reach costs the
/// particles in that reach, not every other's search.
template <int d>
std::vector<Pair> pairs_within_reach(const Spheres<d>& spheres, double range, std::span<const double> reach,
                                     parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg
