#include "src/mechanics/contact_events.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "src/mechanics/step_control.hpp"

namespace lichtenberg::mechanics {

double ContactEvents::contact_gap() const {
  return discharge_ && discharge_->make_gap() > 0 ? discharge_->make_gap() : INFINITY;
}

void ContactEvents::widen(std::span<double> distances) const {
  for (double& distance : distances) distance = 1.01 * distance + tolerance_;
}

ContactPrediction ContactEvents::predict_contacts(const ElectricalState& now, std::span<const double> reach,
                                                  const std::optional<std::vector<int>>& colliding) const {
  if (!discharge_) return {};
  const Stopwatch watch(counters_.contact_seconds);
  ContactPrediction prediction{.watched = discharge_->watch(model_.bodies, now.contacts, now.groups, reach),
                               .least_reach = std::ranges::min(reach)};
  const int d = model_.bodies.dimension;
  const auto add_path = [&](int body) {
    prediction.paths.push_back({.body = body, .reach = reach[body]});
    std::copy_n(&model_.bodies.position[body * d], d, prediction.paths.back().start.begin());
  };
  // Other bodies have not moved.
  if (colliding)
    for (const int body : *colliding) add_path(body);
  else
    for (int body = 0; body < model_.bodies.size(); ++body) add_path(body);
  for (const Watch& w : prediction.watched)
    for (const int body : {w.contact.conductor, w.contact.partner})
      if (body < model_.bodies.size()) add_path(body);
  return prediction;
}

/// Returns event functions for the contacts in `watched`, which must outlive them.
Events ContactEvents::predicted_events(std::span<const Watch> watched, bool mergers_wait) const {
  Events events;
  for (const Watch& w : watched) events.direction.push_back(w.made ? +1 : -1);
  events.predicted_values = [this, watched, mergers_wait](std::span<double> value) {
    for (std::size_t k = 0; k < watched.size(); ++k)
      value[k] = mergers_wait && !watched[k].made ? discharge_->excess_of_deferred(model_.bodies, watched[k])
                                                  : discharge_->excess(model_.bodies, watched[k]);
  };
  for (const Watch& w : watched)
    for (const int body : {w.contact.conductor, w.contact.partner})
      if (body < model_.bodies.size()) events.watched.push_back(body);
  return events;
}

Events ContactEvents::events(const ContactPrediction& prediction, bool mergers_wait) const {
  if (!discharge_) return {};
  Events events = predicted_events(prediction.watched, mergers_wait);
  events.direction.push_back(+1);
  events.values = [this, &prediction, predicted_values = events.predicted_values](std::span<double> value) {
    predicted_values(value);
    value.back() = largest_overshoot(prediction.paths, -prediction.least_reach);
  };
  events.longest_step = [this, &prediction](std::span<const double> force) {
    return longest_step(prediction.watched, force);
  };
  events.subset = [this, &prediction, mergers_wait](std::span<const int> numbers) {
    auto some = std::make_shared<std::vector<Watch>>();
    for (const int k : numbers) some->push_back(prediction.watched[k]);
    Events only = predicted_events(*some, mergers_wait);
    only.values = [some, values = std::exchange(only.predicted_values, {})](std::span<double> value) { values(value); };
    return only;
  };
  return events;
}

ContactEvents::Due ContactEvents::due(const ContactPrediction& prediction) const {
  Due due;
  for (const Watch& w : prediction.watched) {
    const double excess = discharge_->excess(model_.bodies, w);
    (w.made ? due.lost : due.made) |= w.made ? excess >= 0 : excess <= 0;
  }
  return due;
}

/// Returns the largest distance (m) by which a body has moved beyond its reach, at least `farthest`. Square roots are
/// taken only for bodies that may exceed this value.
double ContactEvents::largest_overshoot(std::span<const ContactPrediction::PredictedPath> paths,
                                        double farthest) const {
  const int d = model_.bodies.dimension;
  for (const auto& [body, start, reach] : paths) {
    const double* position = &model_.bodies.position[body * d];
    double moved2 = 0;
    for (int k = 0; k < d; ++k) moved2 += (position[k] - start[k]) * (position[k] - start[k]);
    const double least = farthest + reach;
    if (least < 0 || moved2 > least * least) farthest = std::max(farthest, std::sqrt(moved2) - reach);
  }
  return farthest;
}

/// Returns a step (s) in which no candidate contact can close and open, or open and close, without detection at its
/// end.
double ContactEvents::longest_step(const std::vector<Watch>& watched, std::span<const double> force) const {
  double longest = INFINITY;
  for (const Watch& w : watched)
    longest = std::min(
        longest, time_to_change_gap(model_.bodies, w.contact, force, discharge_->undetected_travel(model_.bodies, w)));
  return longest;
}

double time_to_change_gap(const Bodies& bodies, effects::Contact contact, std::span<const double> force,
                          double change) {
  const int i = contact.conductor, j = contact.partner;
  const auto acceleration = [&](int body) { return vector_at(force, bodies.dimension, body) / bodies.mass[body]; };
  const bool both_move = j < bodies.size();
  const Vec3 v = velocity_in_space(bodies, i) - (both_move ? velocity_in_space(bodies, j) : Vec3{});
  const Vec3 a = acceleration(i) - (both_move ? acceleration(j) : Vec3{});
  return time_to_move(change, norm(v), norm(a));
}

}  // namespace lichtenberg::mechanics
