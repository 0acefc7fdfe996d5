#pragma once

#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Neighbour (Verlet) list: pairs of grains whose surfaces may come closer than a range within a step. A grain that is
/// far faster than the others has a skin of its own, so it enlarges its own neighbourhood only.
class PairList {
 public:
  /// `range` (d0): gap between surfaces. The list is rebuilt when a grain has moved by `move` radii. A large value
  /// saves searches, a small one keeps the list short.
  PairList(double range, double move) : range_(range), move_(move) {}

  /// Returns, in ascending order, all pairs that come closer than the range while no grain moves by more than `travel`
  /// (d0). Other pairs may be among them.
  std::span<const Pair> pairs(const Bodies& bodies, double travel, parallel::Team& team);
  std::int64_t searches() const { return searches_; }

 private:
  bool is_valid_for(const Bodies& bodies, double travel) const;
  void search(const Bodies& bodies, double travel, parallel::Team& team);

  double range_, move_;
  /// d0; positions at the last search, [N * d], and allowed displacements, [N]
  std::vector<double> searched_at_, reach_;
  std::vector<Pair> pairs_;
  std::int64_t searches_ = 0;
};

}  // namespace lichtenberg::granular
