#pragma once

#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Repeated pairs_within_reach() for moving particles. A rebuild finds all pairs within the range plus a skin, the
/// smallest radius; later calls select from these candidates while displacements are small. A particle is far if its
/// reach plus its displacement since the rebuild exceeds half of the skin. It is compared with all particles near it
/// along the first axis, so that a few fast particles cause no rebuild. In a periodic box every call searches again.
class ReachList {
 public:
  /// Returns pairs_within_reach(spheres, range, reach). Throws its exceptions.
  template <int d>
  std::vector<Pair> pairs(const Spheres<d>& spheres, double range, std::span<const double> reach);
  /// Returns the distance (m) that each particle has moved since the last rebuild.
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

  double skin_ = 0, range_ = 0;            ///< Lengths (m); range_: that of the candidates
  std::vector<double> searched_at_;        ///< Positions at the last rebuild
  std::vector<Pair> candidates_;           ///< Candidate pairs in ascending order
  std::vector<double> gap_;                ///< Gap of each candidate at the rebuild (m)
  std::vector<int> by_gap_;                ///< Indices of the candidates by ascending gap
  double largest_radius_ = 0;              ///< m
  std::vector<int> by_coordinate_;         ///< Particles sorted along the first axis, at the rebuild
  std::vector<double> sorted_coordinate_;  ///< Coordinates of these particles along the first axis (m)
  double farthest_ = 0;                    ///< Largest reach plus displacement of particles that are not far (m)
  /// Bounds (m), at least and at most, on the reduction of a gap by a particle's displacement since the rebuild and its
  /// reach; minus infinity for far particles.
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
