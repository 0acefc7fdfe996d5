#pragma once

#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// The pairs of grains whose surfaces may come closer than a range within a step, kept while the grains move. One that
/// is far faster than the others has a reach of its own: it costs its own neighbourhood and not everybody's.
class PairList {
 public:
  /// A search is made anew when a grain has moved by `move` radii: late for a list of many pairs, which is dear to
  /// find, soon for one of which each pair is looked at in each step.
  PairList(double range, double move) : range_(range), move_(move) {}

  /// The pairs, in ascending order, that come closer than the range while no grain moves by more than `travel` from
  /// where it is; may hold others.
  std::span<const Pair> pairs(const Bodies& bodies, double travel, parallel::Team& team);
  std::int64_t searches() const { return searches_; }

 private:
  bool holds(const Bodies& bodies, double travel) const;
  void search(const Bodies& bodies, double travel, parallel::Team& team);

  double range_, move_;
  std::vector<double> searched_at_, reach_;  ///< places of the last search, [N * d], and what each may have moved, [N]
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg::granular
