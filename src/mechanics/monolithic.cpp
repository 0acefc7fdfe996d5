#include "src/mechanics/monolithic.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::mechanics {

Monolithic::Monolithic(Workplace workplace) : at_(workplace), cvode_(make_cvode(at_.scene, at_.model)) {
  if (at_.electrics) cvode_.before_forces = [this](double time) { solve_field(time); };
}

void Monolithic::solve_field(double time) {
  std::vector<Vec2> force = at_.electrics->solve(time).force;
  std::vector<Vec2> rate(force.size());
  at_.electrics->field().hold(time, std::move(force), std::move(rate));
}

void Monolithic::advance(double time, double end) {
  if (!at_.electrics) {
    const Stopwatch watch(at_.counters.mechanics_seconds);
    cvode_.advance(time, end);
    ++at_.counters.steps;
    return;
  }
  while (time < end) time = step(time, end);
}

/// Contacts that may change while no body moves farther than its radius, and one event more, for the first that does:
/// what forces will be is not known beforehand, so it is not either how far bodies will move.
Events Monolithic::events() const {
  const Bodies& bodies = at_.model.bodies;
  Events events = at_.electrics->events(bodies.radius);
  events.direction.push_back(+1);
  events.values = [&bodies, start = bodies.position, contacts = events.values](std::span<double> value) {
    if (contacts) contacts(value.first(value.size() - 1));
    double farthest = -INFINITY;
    for (int i = 0; i < bodies.size(); ++i)
      farthest =
          std::max(farthest, norm(position(bodies, i) - Vec2{start[2 * i], start[2 * i + 1]}) - bodies.radius[i]);
    value.back() = farthest;
  };
  return events;
}

/// To `end`, or to the first event.
double Monolithic::step(double time, double end) {
  const Events ending = events();
  const double field_before = at_.counters.field_seconds;
  double elapsed = 0;
  {
    const Stopwatch watch(elapsed);
    time = cvode_.advance(time, end, ending);
  }
  at_.counters.mechanics_seconds += elapsed - (at_.counters.field_seconds - field_before);
  ++at_.counters.steps;
  at_.electrics->solve(time);
  at_.electrics->settle(time);
  at_.electrics->reconnect(time);
  return time;
}

}  // namespace lichtenberg::mechanics
