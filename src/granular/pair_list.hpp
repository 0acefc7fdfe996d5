#pragma once

#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Neighbour (Verlet) list of pairs of grains whose surfaces may come closer than a range within a step. A grain that
/// is far faster than the others gets a larger skin, so that it enlarges only its own neighbourhood.
class PairList {
 public:
  /// Makes an empty list. `range`: gap between surfaces (d0). The list remains valid while grains move by `move` times
  /// the largest radius, in addition to the path in a step; by less in a short box. A large value saves rebuilds, a
  /// small one keeps the list short.
  PairList(double range, double move) : range_(range), move_(move) {}

  /// Returns, in ascending order, all pairs whose gap may fall below the range while no grain moves by more than
  /// `travel` (d0). Other pairs may be among them. The list is rebuilt if needed. Throws InputError if the box is too
  /// short.
  std::span<const Pair> pairs(const Bodies& bodies, double travel, parallel::Team& team);
  std::int64_t searches() const { return searches_; }

 private:
  /// Returns true if the list is complete while no grain moves by more than `travel` (d0) from now on.
  bool is_valid_for(const Bodies& bodies, double travel) const;
  void search(const Bodies& bodies, double travel, parallel::Team& team);

  double range_, move_;
  /// d0; positions at the last search, [N * d], and allowed displacements, [N]
  std::vector<double> searched_at_, reach_;
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg::granular
