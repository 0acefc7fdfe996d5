#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {
namespace {

/// CVODE with the field inside its right-hand side: each evaluation of forces solves the field. Newton's iteration
/// omits the derivatives of the field. The only error in time is CVODE's, and the cost is high: a reference for Split.
/// In a scene without a field it is CVODE alone.
class Monolithic : public Stepper {
 public:
  explicit Monolithic(StepperContext context);
  void begin(double) override {}
  void advance(double time, double end) override;
  bool limits_moves() const override { return true; }

 private:
  void solve_field(double time);
  double step(double time, double end);

  StepperContext context_;
  Cvode cvode_;
};

Monolithic::Monolithic(StepperContext context) : context_(context), cvode_(make_cvode(context_.scene, context_.model)) {
  record_drag(context_, cvode_);
  cvode_.between_steps = context_.between_steps;
  if (context_.electrics) cvode_.before_forces = [this](double time) { solve_field(time); };
}

void Monolithic::solve_field(double time) {
  Trial trial = context_.electrics->solve(time);
  const std::vector<Vec3> rate(trial.field.force.size());
  context_.electrics->set_extrapolation({.time = time, .force = std::move(trial.field.force), .force_rate = rate});
}

void Monolithic::advance(double time, double end) {
  if (!context_.electrics) {
    const Stopwatch watch(context_.counters.mechanics_seconds);
    cvode_.advance(time, end);
    ++context_.counters.steps;
    context_.commit(end, end - time);
    return;
  }
  while (time < end) {
    const double reached = step(time, end);
    context_.commit(reached, reached - time);
    time = reached;
  }
}

/// Advances to `end`, or to the first event. Returns the time reached.
double Monolithic::step(double time, double end) {
  // Forces of the step, and so the travel of bodies, are not known in advance; a radius is the reach.
  std::vector<double> reach = context_.model.bodies.radius;
  const ContactEvents& contacts = context_.electrics->contact_events();
  contacts.widen(reach);
  const ContactPrediction prediction = contacts.predict_contacts(context_.electrics->now(), reach);
  const Events events = contacts.events(prediction);
  const double field_before = context_.counters.field_seconds;
  double elapsed = 0;
  {
    const Stopwatch watch(elapsed);
    time = cvode_.advance(time, end, events);
  }
  context_.counters.mechanics_seconds += elapsed - (context_.counters.field_seconds - field_before);
  ++context_.counters.steps;
  context_.electrics->accept(context_.electrics->solve(time));
  context_.electrics->reconnect(time);
  return time;
}

}  // namespace

std::unique_ptr<Stepper> make_monolithic(const StepperContext& context) {
  return std::make_unique<Monolithic>(context);
}

}  // namespace lichtenberg::mechanics
