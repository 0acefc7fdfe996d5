#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg {

/// Two bodies, i < j.
struct Pair {
  int i = 0, j = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Calls task(k) for k from 0 to tasks - 1, in any order: how threads, if there are any, share a search.
using Share = std::function<void(int tasks, const std::function<void(int)>& task)>;
/// One after the other.
void in_turn(int tasks, const std::function<void(int)>& task);

/// All pairs whose surfaces are closer than `range` (m; overlapping ones included), in ascending order. The work grows
/// with the number of bodies and of pairs: bodies are sorted into cells that a pair cannot reach across.
std::vector<Pair> pairs_closer_than(const Bodies& bodies, double range, const Share& share = in_turn);

/// The same with a reach (m, [N], not negative) of each body's own: all pairs whose surfaces are closer than `range`
/// and both reaches together. One body with a long reach costs the bodies in that reach, not every other's search.
std::vector<Pair> pairs_within_reach(const Bodies& bodies, double range, std::span<const double> reach,
                                     const Share& share = in_turn);

/// The pairs within `range`, kept up to date while bodies move. A new search is made only when a body has moved by
/// half of `skin`; until then the list, which holds all pairs that were within range + skin, cannot miss one.
class NeighbourList {
 public:
  NeighbourList(double range, double skin) : range_(range), skin_(skin) {}

  /// Makes pairs() complete for these positions.
  void update(const Bodies& bodies);
  /// The two halves of `update`: whether these positions of the bodies from `first` on up to before `end` leave pairs()
  /// complete, and the search that makes it so.
  bool covers(const Bodies& bodies, int first, int end) const;
  void search(const Bodies& bodies, const Share& share = in_turn);
  /// In ascending order, so that sums over pairs do not depend on when the list was made.
  std::span<const Pair> pairs() const { return pairs_; }
  std::int64_t searches() const { return searches_; }

 private:
  double range_, skin_;
  std::vector<double> searched_at_;  ///< positions of the last search
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg
