#pragma once

#include <span>
#include <vector>

#include "src/mechanics/defect_correction.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// Jump of the electric forces (N, by body) at an instant: forces before and after it. operator[] returns the
/// difference.
struct ForceJump {
  const std::vector<Vec3>&before, &after;
  Vec3 operator[](int body) const { return after[body] - before[body]; }
};

/// Defers group merges (closing contacts that join two equipotential groups), so that several share one field solve.
/// Corrects positions for the delay.
class MergerScheduler {
 public:
  /// Makes a scheduler. All arguments must outlive this object.
  MergerScheduler(const Scene& scene, Model& model, const FreeFlight& flight);

  /// Returns the longest time (s) by which a group merge may be delayed.
  double merge_deferral() const { return merge_deferral_; }
  void set_merge_deferral(double merge_deferral) { merge_deferral_ = merge_deferral; }
  /// Sets the longest time by which the next group merges may be delayed, at most largest_step of the scene. In this
  /// time a jump like this one displaces no body by more than half a position tolerance. After the first call, the time
  /// grows by at most 25 % in a call. The displacement is bounded from above by the smaller of its limits for drag and
  /// for inertia.
  void update_merge_deferral(const ForceJump& jump);
  /// Corrects positions and momenta of bodies except `fixed` (in ascending order) at `time` (s). The bodies have moved
  /// without the jump of the forces from the times on at which the group merges were due. Negligible corrections are
  /// left out. So are corrections of more than a position tolerance that may bring a body into contact.
  void correct_positions(double time, std::span<const Merger> mergers, const ForceJump& jump,
                         std::span<const int> fixed);

 private:
  /// Delay of a group merge and the positions of its two bodies (m). For a merge with an electrode or a side both
  /// positions are the conductor's.
  struct MergeDelay {
    double delay = 0;  ///< s; below 0: the merge is early
    Vec3 one, other;
  };
  std::vector<MergeDelay> merge_delays(double time, std::span<const Merger> mergers) const;
  double mean_delay(int body, std::span<const MergeDelay> mergers) const;
  void correct_large_displacements(std::span<const MergeDelay> mergers, const ForceJump& jump,
                                   std::span<const int> fixed);

  Model& model_;
  const FreeFlight& flight_;
  DefectCorrection correction_;
  double tolerance_;           ///< m, position_tolerance
  double longest_;             ///< s, largest_step
  double merge_deferral_ = 0;  ///< s
};

}  // namespace lichtenberg::mechanics
