#pragma once

#include <span>
#include <vector>

#include "src/mechanics/defect_correction.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// Electric forces (N) before and after a jump.
struct ForceJump {
  const std::vector<Vec3>&before, &after;
  Vec3 operator[](int body) const { return after[body] - before[body]; }
};

/// Lets group merges wait for others, so that they share a field solve, and corrects the positions for the wait.
class MergerScheduler {
 public:
  /// All arguments must outlive this object.
  MergerScheduler(const Scene& scene, Model& model, const FreeFlight& flight);

  /// Longest wait (s) of a group merge.
  double merge_deferral() const { return merge_deferral_; }
  void set_merge_deferral(double merge_deferral) { merge_deferral_ = merge_deferral; }
  /// Sets the wait of the next group merges: the time in which a jump like this one displaces no body by more than half
  /// a tolerance. The displacement is bounded from above by the smaller of its limits for drag and for inertia.
  void update_merge_deferral(const ForceJump& jump);
  /// Corrects the positions of all bodies except `fixed` (in ascending order): they were moved without the change of
  /// the forces from the time at which the group merges were due.
  void correct_positions(double time, std::span<const Merger> mergers, const ForceJump& jump,
                         std::span<const int> fixed);

 private:
  /// Delay of a group merge (s; below 0 if it is early) and the positions of its two bodies (m). For a merge with a
  /// terminal both are the conductor's.
  struct MergeDelay {
    double delay = 0;  ///< s
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
