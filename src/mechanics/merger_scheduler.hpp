#pragma once

#include <span>
#include <vector>

#include "src/mechanics/defect_correction.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/mechanics/free_flight.hpp"

namespace lichtenberg::mechanics {

/// By how much the electric forces (N) have jumped at an instant.
struct Jump {
  const std::vector<Vec3>&before, &after;
  Vec3 operator[](int body) const { return after[body] - before[body]; }
};

/// How long mergers that are due wait for others, to share a field solve with them, and what makes up for the wait.
class MergerScheduler {
 public:
  /// All must outlive this.
  MergerScheduler(const Scene& scene, Model& model, const FreeFlight& flight);

  /// How long (s) a merger may wait.
  double patience() const { return patience_; }
  void set_patience(double patience) { patience_ = patience; }
  /// The next mergers may wait as long as their jumps, if they are like this, move nothing by more than half a
  /// tolerance: from above by the lesser of the limits of drag and of inertia.
  void learn(const Jump& jump);
  /// Mergers have changed the forces since they were due, and bodies have been moved without that change. All but
  /// those in `fixed` (in ascending order) are moved by it now.
  void make_up(double time, std::span<const Merger> mergers, const Jump& jump, std::span<const int> fixed);

 private:
  /// Places of the two of a merger (of one with a terminal twice the conductor), and how late it is: below 0 of one
  /// that is early.
  struct Lateness {
    double by = 0;  ///< s
    Vec3 one, other;
  };
  std::vector<Lateness> lateness(double time, std::span<const Merger> mergers) const;
  double late_by(int body, std::span<const Lateness> mergers) const;
  void make_up_far(std::span<const Lateness> mergers, const Jump& jump, std::span<const int> fixed);

  Model& model_;
  const FreeFlight& flight_;
  DefectCorrection correction_;
  double tolerance_;     ///< m, of positions
  double longest_;       ///< s
  double patience_ = 0;  ///< s
};

}  // namespace lichtenberg::mechanics
