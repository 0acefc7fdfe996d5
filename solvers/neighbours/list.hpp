#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Verlet neighbour list: contains all pairs of moving particles with a surface distance below `range`. At a rebuild it
/// gets all pairs within range + skin. update() rebuilds it when a particle has moved by more than half of `skin`;
/// until then it contains every pair within `range`. Crossing a periodic boundary does not count as motion.
class NeighbourList {
 public:
  /// Makes an empty list; `range` and `skin` are in m.
  NeighbourList(double range, double skin) : range_(range), skin_(skin) {}

  /// Rebuilds the list if necessary, so that pairs() contains all pairs within the range at these positions. Throws the
  /// exceptions of pairs_closer_than.
  template <int d>
  void update(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// Checks whether the list is still valid. Returns true if none of the particles first ... end - 1 has moved by more
  /// than half of the skin since the last rebuild. Returns false if the number of particles has changed or no list was
  /// built. update() checks all particles and calls search() if the list is not valid.
  template <int d>
  bool covers(const Spheres<d>& spheres, int first, int end) const;
  /// Checks whether the list is still valid as far as the particles `some` (indices) are concerned. Returns false if
  /// one of them has moved by more than half of the skin since the last rebuild. Also returns false if the number of
  /// particles has changed or no list was built.
  template <int d>
  bool covers(const Spheres<d>& spheres, std::span<const int> some) const;
  /// Rebuilds the list from these positions. Throws the exceptions of pairs_closer_than.
  template <int d>
  void search(const Spheres<d>& spheres, parallel::Team& team = parallel::Team::single());
  /// Returns the listed pairs in ascending order: while the list is valid, all pairs within the range, and others. With
  /// this order, sums over the pairs within the range do not depend on the time of the rebuild.
  std::span<const Pair> pairs() const { return pairs_; }
  /// Returns the number of rebuilds, including the first construction.
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
