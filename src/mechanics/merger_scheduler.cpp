#include "src/mechanics/merger_scheduler.hpp"

#include <algorithm>
#include <cmath>

#include "src/model/body_ranges.hpp"

namespace lichtenberg::mechanics {

MergerScheduler::MergerScheduler(const Scene& scene, Model& model, const FreeFlight& flight)
    : model_(model),
      flight_(flight),
      correction_(model),
      tolerance_(scene.mechanics.position_tolerance),
      longest_(scene.mechanics.largest_step) {}

void MergerScheduler::correct_positions(double time, std::span<const Merger> mergers, const ForceJump& jump,
                                        std::span<const int> fixed) {
  if (mergers.empty()) return;
  const Bodies& bodies = model_.bodies;
  const std::span<const double> drag = model_.drag.linear();
  const std::vector<MergeDelay> all = merge_delays(time, mergers);
  double longest = 0;
  for (const MergeDelay& merger : all) longest = std::max(longest, std::abs(merger.delay));
  const auto largest_displacement = [&](int first, int end) {
    double farthest = 0;
    FreeFallCache last;
    for (int i = first; i < end; ++i) {
      const double size = norm(jump[i]), mass = bodies.mass[i];
      const double lasting = drag[i] > 0 ? mass / drag[i] : longest_;  // duration of the motion after an impulse
      if (size * longest * lasting < 1e-2 * tolerance_ * mass || std::ranges::binary_search(fixed, i)) continue;
      const double delay = mean_delay(i, all),
                   displacement = delay > 0 ? correction_.displacement(last, i, delay, size) : 0;
      if (displacement <= tolerance_) correction_.apply(last, i, delay, jump[i], {});
      farthest = std::max(farthest, displacement);
    }
    return farthest;
  };
  if (largest_of_ranges(*model_.team, bodies.size(), 0, largest_displacement) > tolerance_)
    correct_large_displacements(all, jump, fixed);
}

/// Corrects bodies by more than a tolerance, after a jump that is larger than the jumps before it. The search for
/// contacts covered a tolerance only. A body that may touch another on its path therefore stays in its position.
void MergerScheduler::correct_large_displacements(std::span<const MergeDelay> mergers, const ForceJump& jump,
                                                  std::span<const int> fixed) {
  const int n = model_.bodies.size();
  FreeFallCache last;
  std::vector<double> displacement(n);
  for (int i = 0; i < n; ++i) {
    const double delay = mean_delay(i, mergers);
    if (delay > 0) displacement[i] = correction_.displacement(last, i, delay, norm(jump[i]));
    if (displacement[i] <= tolerance_) displacement[i] = 0;
  }
  const std::vector<int> may_touch = flight_.interacting(displacement);
  for (int i = 0; i < n; ++i)
    if (displacement[i] > 0 && !std::ranges::binary_search(fixed, i) && !std::ranges::binary_search(may_touch, i))
      correction_.apply(last, i, mean_delay(i, mergers), jump[i], {});
}

void MergerScheduler::update_merge_deferral(const ForceJump& jump) {
  const Bodies& bodies = model_.bodies;
  const std::span<const double> drag = model_.drag.linear();
  const auto least_wait = [&](int first, int end) {
    double longest = longest_;
    for (int i = first; i < end; ++i) {
      const double size = norm(jump[i]);
      if (size * std::min(longest * longest / (2 * bodies.mass[i]), longest / drag[i]) > 0.5 * tolerance_)
        longest = std::max(std::sqrt(bodies.mass[i] * tolerance_ / size), 0.5 * drag[i] * tolerance_ / size);
    }
    return longest;
  };
  const double longest = least_of_ranges(*model_.team, bodies.size(), longest_, least_wait);
  constexpr double growth = 1.25;  // slow: the wait stays at that of the largest recent jumps
  merge_deferral_ = merge_deferral_ == 0 ? longest : std::min(longest, growth * merge_deferral_);
}

/// Returns the delays of group merges at positions that are not yet corrected. The gap of an early merge may close so
/// slowly that its due time is far ahead. Such a merge counts as early by the longest wait at most.
std::vector<MergerScheduler::MergeDelay> MergerScheduler::merge_delays(double time,
                                                                       std::span<const Merger> mergers) const {
  const Bodies& bodies = model_.bodies;
  std::vector<MergeDelay> all;
  for (const auto& [contact, due] : mergers) {
    const Vec3 one = position_in_space(bodies, contact.conductor);
    all.push_back({std::max(time - due, -merge_deferral_), one,
                   contact.partner < bodies.size() ? position_in_space(bodies, contact.partner) : one});
  }
  return all;
}

/// Returns the time (s) for which a body has moved without the jump of its force. Several group merges that share a
/// solve give only the sum of their jumps. The time is the mean of their delays. Its weights are the square of a
/// dipole's field in the plane at the body, so that near merges count most.
double MergerScheduler::mean_delay(int body, std::span<const MergeDelay> mergers) const {
  const Bodies& bodies = model_.bodies;
  const NearestImage<3> nearest(bodies.box);
  const Vec3 here = position_in_space(bodies, body);
  const auto distance2 = [&](Vec3 there) {
    Vec3 separation = here - there;
    for (int k = 0; k < 3; ++k) separation[k] = nearest(separation[k], k);
    return norm2(separation);
  };
  double weights = 0, sum = 0;
  for (const auto& [delay, one, other] : mergers) {
    const double near2 = std::min(distance2(one), distance2(other)) + bodies.radius[body] * bodies.radius[body];
    const double weight = 1 / (near2 * near2);
    weights += weight;
    sum += weight * delay;
  }
  return sum / weights;
}

}  // namespace lichtenberg::mechanics
