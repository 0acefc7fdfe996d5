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

void MergerScheduler::make_up(double time, std::span<const Merger> mergers, const Jump& jump,
                              std::span<const int> fixed) {
  if (mergers.empty()) return;
  const Bodies& bodies = model_.bodies;
  const std::span<const double> drag = model_.drag.linear();
  const std::vector<Lateness> all = lateness(time, mergers);
  double longest = 0;
  for (const Lateness& merger : all) longest = std::max(longest, std::abs(merger.by));
  const auto most_way = [&](int first, int end) {
    double farthest = 0;
    LastFall last;
    for (int i = first; i < end; ++i) {
      const double size = norm(jump[i]), mass = bodies.mass[i];
      const double lasting = drag[i] > 0 ? mass / drag[i] : longest_;  // duration of the motion after an impulse
      if (size * longest * lasting < 1e-2 * tolerance_ * mass || std::ranges::binary_search(fixed, i)) continue;
      const double late = late_by(i, all), way = late > 0 ? correction_.way(last, i, late, size) : 0;
      if (way <= tolerance_) correction_.apply(last, i, late, jump[i], {});
      farthest = std::max(farthest, way);
    }
    return farthest;
  };
  if (largest_of_ranges(*model_.team, bodies.size(), 0, most_way) > tolerance_) make_up_far(all, jump, fixed);
}

/// Corrects bodies by more than a tolerance, after a jump that is larger than the jumps before it. The search for
/// contacts covered a tolerance only, so that a body that may touch another on its path stays in its position.
void MergerScheduler::make_up_far(std::span<const Lateness> mergers, const Jump& jump, std::span<const int> fixed) {
  const int n = model_.bodies.size();
  LastFall last;
  std::vector<double> way(n);
  for (int i = 0; i < n; ++i) {
    const double late = late_by(i, mergers);
    if (late > 0) way[i] = correction_.way(last, i, late, norm(jump[i]));
    if (way[i] <= tolerance_) way[i] = 0;
  }
  const std::vector<int> may_touch = flight_.pushed(way);
  for (int i = 0; i < n; ++i)
    if (way[i] > 0 && !std::ranges::binary_search(fixed, i) && !std::ranges::binary_search(may_touch, i))
      correction_.apply(last, i, late_by(i, mergers), jump[i], {});
}

void MergerScheduler::learn(const Jump& jump) {
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
  patience_ = patience_ == 0 ? longest : std::min(longest, growth * patience_);
}

/// Returns the delays of group merges at positions that are not yet corrected. An early merge may be so slow that its
/// due time is far ahead, or never; it counts as early by the longest wait at most.
std::vector<MergerScheduler::Lateness> MergerScheduler::lateness(double time, std::span<const Merger> mergers) const {
  const Bodies& bodies = model_.bodies;
  std::vector<Lateness> all;
  for (const auto& [contact, due] : mergers) {
    const Vec3 one = position_in_space(bodies, contact.conductor);
    all.push_back({std::max(time - due, -patience_), one,
                   contact.partner < bodies.size() ? position_in_space(bodies, contact.partner) : one});
  }
  return all;
}

/// Returns the time (s) for which a body has moved without the jump of its force. Several group merges that share a
/// solve give only the sum of their jumps. The time is the mean of their delays, weighted by the square of a dipole's
/// field in the plane at the body, so that near merges count most.
double MergerScheduler::late_by(int body, std::span<const Lateness> mergers) const {
  const Bodies& bodies = model_.bodies;
  const NearestImage<3> nearest(bodies.box);
  const Vec3 here = position_in_space(bodies, body);
  const auto distance2 = [&](Vec3 there) {
    Vec3 apart = here - there;
    for (int k = 0; k < 3; ++k) apart[k] = nearest(apart[k], k);
    return norm2(apart);
  };
  double weights = 0, sum = 0;
  for (const auto& [by, one, other] : mergers) {
    const double near2 = std::min(distance2(one), distance2(other)) + bodies.radius[body] * bodies.radius[body];
    const double weight = 1 / (near2 * near2);
    weights += weight;
    sum += weight * by;
  }
  return sum / weights;
}

}  // namespace lichtenberg::mechanics
