#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Neighbour (Verlet) list: pairs within `range`, kept up to date while particles move. The list contains all pairs
/// within range + skin. It is rebuilt only when a particle has moved by half of `skin`; until then it cannot miss a
/// pair. Crossing a periodic boundary does not count as motion.
class NeighbourList {
 public:
  NeighbourList(double range, double skin) : range_(range), skin_(skin) {}

  /// Makes pairs() complete for these positions. Throws the exceptions of pairs_closer_than.
  template <int d>
  void update(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// First half of `update`: returns true if pairs() is complete for the present positions of the particles from
  /// `first` up to before `end`. False if the number of particles has changed. `search`, the second half, rebuilds the
  /// list.
  template <int d>
  bool covers(const Spheres<d>& spheres, int first, int end) const;
  /// Like `covers` above, for some of the particles.
  template <int d>
  bool covers(const Spheres<d>& spheres, std::span<const int> some) const;
  template <int d>
  void search(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// Pairs in ascending order, so that sums over pairs do not depend on the time of the rebuild.
  std::span<const Pair> pairs() const { return pairs_; }
  std::int64_t searches() const { return searches_; }

 private:
  template <int d>
  bool has_moved_too_far(const Spheres<d>& spheres, int i) const;

  double range_, skin_;
  std::vector<double> searched_at_;  ///< Positions at the last rebuild
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg
