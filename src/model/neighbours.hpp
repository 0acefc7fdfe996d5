#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg {

/// Two bodies, i < j.
struct Pair {
  int i = 0, j = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// All pairs whose surfaces are closer than `range` (m; overlapping ones included), in ascending order. The work grows
/// with the number of bodies and of pairs: bodies are sorted into cells that a pair cannot reach across.
std::vector<Pair> pairs_closer_than(const Bodies& bodies, double range);

/// The same with a reach (m, [N], not negative) of each body's own: all pairs whose surfaces are closer than `range`
/// and both reaches together. One body with a long reach costs the bodies in that reach, not every other's search.
std::vector<Pair> pairs_within_reach(const Bodies& bodies, double range, std::span<const double> reach);

/// The pairs within `range`, kept up to date while bodies move. A new search is made only when a body has moved by
/// half of `skin`; until then the list, which holds all pairs that were within range + skin, cannot miss one.
class NeighbourList {
 public:
  NeighbourList(double range, double skin) : range_(range), skin_(skin) {}

  /// Makes pairs() complete for these positions.
  void update(const Bodies& bodies);
  /// In ascending order, so that sums over pairs do not depend on when the list was made.
  std::span<const Pair> pairs() const { return pairs_; }
  std::int64_t searches() const { return searches_; }

 private:
  bool moved_too_far(const Bodies& bodies) const;

  double range_, skin_;
  std::vector<double> searched_at_;  ///< positions of the last search
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg
