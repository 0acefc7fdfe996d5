#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// pairs_within_reach() for particles that are asked for time and again while they move. A search finds all pairs
/// within the range and a skin of the smallest radius; as long as particles have moved little, later pairs are looked
/// for among these. A particle whose reach and way since the search are more than half of the skin together is compared
/// with all that are near it along the first axis, so that a few fast ones make no search. In a periodic box every look
/// is a search.
class ReachList {
 public:
  /// As pairs_within_reach(spheres, range, reach). Throws what that throws.
  template <int d>
  std::vector<Pair> pairs(const Spheres<d>& spheres, double range, std::span<const double> reach);
  /// How far (m) each particle is from where it was at the last search.
  std::span<const double> moved() const { return moved_; }
  int searches() const { return searches_; }

 private:
  template <int d>
  bool covers(const Spheres<d>& spheres, double range, std::span<const double> reach);
  template <int d>
  void search(const Spheres<d>& spheres, double range);
  template <int d>
  void note_search(const Spheres<d>& spheres);
  template <int d>
  void add_far(const Spheres<d>& spheres, double range, std::span<const double> reach, std::vector<Pair>& found) const;

  double skin_ = 0, range_ = 0;      ///< m; range: of the candidates
  std::vector<double> searched_at_;  ///< positions
  std::vector<Pair> candidates_;     ///< in ascending order
  std::vector<double> gap_;          ///< m, of these at the search
  std::vector<int> by_gap_;          ///< their numbers, the closest first
  double largest_radius_ = 0;        ///< m
  std::vector<int> along_;           ///< particles as they lay along the first axis at the search
  std::vector<double> along_at_;     ///< m, where
  double farthest_ = 0;              ///< m: reach and way together of those that are not far
  /// By how much (m) a particle's way since the search and its reach have narrowed a gap, at least and at most; no gap
  /// of those that are far.
  struct Room {
    double least = 0, most = 0;
  };
  std::vector<Room> room_;
  std::vector<double> moved_;
  std::vector<int> far_;  ///< those whose pairs are no candidates
  std::vector<char> is_far_;
  int searches_ = 0;
};

}  // namespace lichtenberg
