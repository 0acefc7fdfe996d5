#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Verlet list for repeated pairs_within_reach() of moving particles. A rebuild finds the candidates: all pairs within
/// the range plus a skin (the smallest radius). Later calls select from the candidates, until too many particles are
/// far or the range exceeds that of the candidates.
/// A particle is far if its reach plus its displacement since the rebuild exceeds half of a margin. The margin is the
/// range of the candidates minus the range of the call. A far particle is compared with all particles near it along the
/// first axis, so that a few fast particles cause no rebuild. In a periodic box every call of pairs() searches again.
class ReachList {
 public:
  /// Returns the pairs (i < j, in ascending order) with a gap below range + reach[i] + reach[j], all in m: the result
  /// of pairs_within_reach(). Throws its exceptions.
  template <int d>
  std::vector<Pair> pairs(const Spheres<d>& spheres, double range, std::span<const double> reach);
  /// Returns the distance (m) that each particle has moved between the last rebuild and the last call of pairs().
  std::span<const double> moved() const { return moved_; }
  /// Returns the number of rebuilds, including the first construction; in a periodic box, of calls of pairs().
  int searches() const { return searches_; }

 private:
  /// Updates displacements and far particles; returns false if a rebuild is needed.
  template <int d>
  bool covers(const Spheres<d>& spheres, double range, std::span<const double> reach);
  template <int d>
  void search(const Spheres<d>& spheres, double range);
  template <int d>
  void note_search(const Spheres<d>& spheres);
  template <int d>
  void add_far(const Spheres<d>& spheres, double range, std::span<const double> reach, std::vector<Pair>& found) const;

  double skin_ = 0, range_ = 0;            ///< Skin, and largest gap of the candidates at the rebuild (m)
  std::vector<double> searched_at_;        ///< Positions at the last rebuild
  std::vector<Pair> candidates_;           ///< Candidate pairs in ascending order
  std::vector<double> gap_;                ///< Gap of each candidate at the rebuild (m)
  std::vector<int> by_gap_;                ///< Indices of the candidates by ascending gap
  double largest_radius_ = 0;              ///< Largest radius (m)
  std::vector<int> by_coordinate_;         ///< Particles sorted along the first axis, at the rebuild
  std::vector<double> sorted_coordinate_;  ///< Coordinates of these particles along the first axis (m)
  double farthest_ = 0;                    ///< Largest reach plus displacement of particles that are not far (m)
  /// Lower and upper bound (m) on the reduction of a pair's gap by one of its particles: its reach plus or minus its
  /// displacement since the rebuild. Minus infinity for far particles.
  struct GapReduction {
    double least = 0, most = 0;
  };
  std::vector<GapReduction> gap_reduction_;
  std::vector<double> moved_;
  std::vector<int> far_;  ///< Far particles, whose pairs are not among the candidates
  std::vector<char> is_far_;
  int searches_ = 0;
};

}  // namespace lichtenberg
