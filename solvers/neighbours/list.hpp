#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// The pairs within `range`, kept up to date while particles move. A new search is made only when a particle has moved
/// by half of `skin`; until then the list, which holds all pairs that were within range + skin, cannot miss one. That a
/// particle left a periodic box and came in on the other side is no motion.
class NeighbourList {
 public:
  NeighbourList(double range, double skin) : range_(range), skin_(skin) {}

  /// Makes pairs() complete for these places. Throws what pairs_closer_than throws.
  template <int d>
  void update(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// The two halves of `update`: whether these places of the particles from `first` on up to before `end` leave pairs()
  /// complete (those of another number of particles never do), and the search that makes it so.
  template <int d>
  bool covers(const Spheres<d>& spheres, int first, int end) const;
  /// The first half for some of the particles.
  template <int d>
  bool covers(const Spheres<d>& spheres, std::span<const int> some) const;
  template <int d>
  void search(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// In ascending order, so that sums over pairs do not depend on when the list was made.
  std::span<const Pair> pairs() const { return pairs_; }
  std::int64_t searches() const { return searches_; }

 private:
  template <int d>
  bool has_left(const Spheres<d>& spheres, int i) const;

  double range_, skin_;
  std::vector<double> searched_at_;  ///< positions of the last search
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg
