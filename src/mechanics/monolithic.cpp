#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {
namespace {

/// CVODE with the field inside its right-hand side: each evaluation of forces solves the field. Newton's iteration
/// omits the derivatives of the field. The only error in time is CVODE's, and the cost is high: a reference for Split.
/// In a scene without a field it is CVODE alone.
class Monolithic : public Stepper {
 public:
  explicit Monolithic(Workplace workplace);
  void begin(double) override {}
  void advance(double time, double end) override;

 private:
  void solve_field(double time);
  double step(double time, double end);

  Workplace at_;
  Cvode cvode_;
};

Monolithic::Monolithic(Workplace workplace) : at_(workplace), cvode_(make_cvode(at_.scene, at_.model)) {
  book_drag(at_, cvode_);
  cvode_.between_steps = at_.between_steps;
  if (at_.electrics) cvode_.before_forces = [this](double time) { solve_field(time); };
}

void Monolithic::solve_field(double time) {
  Trial trial = at_.electrics->solve(time);
  const std::vector<Vec3> rate(trial.field.force.size());
  at_.electrics->hold({.time = time, .force = std::move(trial.field.force), .force_rate = rate});
}

void Monolithic::advance(double time, double end) {
  if (!at_.electrics) {
    const Stopwatch watch(at_.counters.mechanics_seconds);
    cvode_.advance(time, end);
    wrap(at_.model.bodies);
    ++at_.counters.steps;
    at_.model.accept(end, end - time);
    return;
  }
  while (time < end) {
    const double reached = step(time, end);
    at_.model.accept(reached, reached - time);
    time = reached;
  }
}

/// Advances to `end`, or to the first event. Returns the time reached.
double Monolithic::step(double time, double end) {
  // Forces of the step, and so the travel of bodies, are not known in advance; a radius is the reach.
  std::vector<double> reach = at_.model.bodies.radius;
  const ContactEvents& contacts = at_.electrics->contact_events();
  contacts.widen(reach);
  const Lookahead ahead = contacts.look_ahead(at_.electrics->now(), reach);
  const Events events = contacts.events(ahead);
  const double field_before = at_.counters.field_seconds;
  double elapsed = 0;
  {
    const Stopwatch watch(elapsed);
    time = cvode_.advance(time, end, events);
  }
  at_.counters.mechanics_seconds += elapsed - (at_.counters.field_seconds - field_before);
  ++at_.counters.steps;
  at_.electrics->accept(at_.electrics->solve(time));
  at_.electrics->reconnect(time);
  wrap(at_.model.bodies);
  return time;
}

}  // namespace

std::unique_ptr<Stepper> make_monolithic(const Workplace& workplace) { return std::make_unique<Monolithic>(workplace); }

}  // namespace lichtenberg::mechanics
