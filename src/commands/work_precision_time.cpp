#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "src/commands/work_precision.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/mechanics/simulation.hpp"

namespace lichtenberg::work_precision {
namespace {

/// Motion of the scene with one field solver for all candidates, so accurate that the time integration dominates the
/// error.
struct MovingSubject {
  Scene scene;
  bool multipole = false;  ///< field by the multipole method
  double field_tolerance = 0;
  double radius = 0;            ///< m, the smallest
  std::vector<Vec3> reference;  ///< m, positions at the end
  std::int64_t contacts = 0;    ///< number made and lost during the run
};

std::unique_ptr<laplace::LaplaceSolver> make_solver(const MovingSubject& subject) {
  if (!subject.scene.effects.has(&EffectKind::field)) return nullptr;
  if (subject.multipole)
    return std::make_unique<laplace::MultipoleSolver>(laplace::MultipoleOptions{.tolerance = subject.field_tolerance});
  FieldOptions options = subject.scene.field();
  options.tolerance = subject.field_tolerance;
  return effects::make_field_solver(options);
}

/// Returns the largest distance between corresponding conductors, in smallest radii.
double distance(const MovingSubject& subject, const std::vector<Vec3>& one, const std::vector<Vec3>& other) {
  double largest = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    if (const double separation = norm(one[i] - other[i]); !(separation <= largest))
      largest = separation;  // NaN is kept
  return largest / subject.radius;
}

/// Trial: a run of the whole scene.
class TimeTrial : public Trial {
 public:
  TimeTrial(const MovingSubject& subject, const MechanicsOptions& mechanics)
      : subject_(subject), scene_(subject.scene) {
    scene_.mechanics = mechanics;
    scene_.mechanics.largest_step = scene_.stop.time;  // only the tolerance limits the steps
  }

  void run() override {
    Simulation simulation(scene_, make_solver(subject_));
    simulation.advance_to(scene_.stop.time);
    position_ = simulation.now().position;
    counters_ = simulation.counters();
  }
  std::vector<double> errors() const override { return {distance(subject_, position_, subject_.reference)}; }
  std::int64_t work() const override { return counters_.field_solves; }
  const std::vector<Vec3>& position() const { return position_; }
  std::int64_t contacts() const { return counters_.contacts_made + counters_.contacts_lost; }

 private:
  const MovingSubject& subject_;
  Scene scene_;
  std::vector<Vec3> position_;
  Counters counters_;
};

MechanicsOptions monolithic_at(double tolerance) {
  return {.integrator = Integrator::cvode, .coupling = FieldCoupling::monolithic, .relative_tolerance = tolerance};
}

/// Returns split coupling with CVODE a thousand times more accurate than the coupling step, as by default; at least
/// 1e-12 because of rounding.
MechanicsOptions split_at(double tolerance, double radius) {
  return {.integrator = Integrator::cvode,
          .coupling = FieldCoupling::split,
          .relative_tolerance = std::max(1e-3 * tolerance, 1e-12),
          .position_tolerance = tolerance * radius};
}

/// Returns Euler's method with a hundred mechanical steps per field solve, as in D 6.7.
MechanicsOptions euler_at(double step) {
  return {.integrator = Integrator::euler, .euler_step = step / 100, .euler_field_step = step};
}

Candidate candidate(const MovingSubject& subject, Settings settings, double cost, const MechanicsOptions& mechanics) {
  return {std::move(settings), cost, [&subject, mechanics] { return std::make_unique<TimeTrial>(subject, mechanics); }};
}

Method split(const MovingSubject& subject, double tightest) {
  Method method{"split", "field extrapolated over error-controlled coupling steps, mechanics by CVODE", {}};
  for (int decade = 1; std::pow(10, -decade) > 0.9 * tightest; ++decade) {
    const double tolerance = std::pow(10, -decade);
    method.candidates.push_back(candidate(subject, {{"position tolerance / R", tolerance}}, std::cbrt(1 / tolerance),
                                          split_at(tolerance, subject.radius)));
  }
  return method;
}

Method monolithic(const MovingSubject& subject, double tightest) {
  Method method{"monolithic", "CVODE with the field solved in every evaluation", {}};
  for (int decade = 2; std::pow(10, -decade) > 0.9 * tightest; ++decade) {
    const double tolerance = std::pow(10, -decade);
    method.candidates.push_back(
        candidate(subject, {{"relative tolerance", tolerance}}, std::pow(tolerance, -0.25), monolithic_at(tolerance)));
  }
  return method;
}

Method euler(const MovingSubject& subject) {
  Method method{"euler", "explicit Euler with a fixed step, a hundred of mechanics to a field solve (D 6.7)", {}};
  for (int solves = 16; solves <= 4096; solves *= 2) {
    const double step = subject.scene.stop.time / solves;
    method.candidates.push_back(candidate(subject, {{"field step (s)", step}}, solves, euler_at(step)));
  }
  return method;
}

/// Returns the methods. On a grid, discretization noise of the forces makes tolerances below the second argument costly
/// without gain.
std::vector<Method> all_methods(const MovingSubject& subject) {
  if (subject.multipole) return {split(subject, 1e-7), monolithic(subject, 1e-8), euler(subject)};
  return {split(subject, 1e-5), monolithic(subject, 1e-5), euler(subject)};
}

/// Computes the reference at tolerances at least a hundred times below those of the sweep. The change at ten times its
/// tolerance bounds its error.
void find_reference(MovingSubject& subject, const MechanicsOptions& tight, const MechanicsOptions& looser,
                    Diagram& diagram) {
  TimeTrial best(subject, tight), second(subject, looser);
  best.run();
  second.run();
  subject.reference = best.position();
  subject.contacts = best.contacts();
  diagram.reference_errors = {distance(subject, second.position(), best.position())};
}

/// Chooses the multipole method, whose forces are smooth in time, or else the scene's own method.
void choose_field(MovingSubject& subject, Diagram& diagram) {
  try {
    subject.multipole = true;
    subject.field_tolerance = 1e-12;
    find_reference(subject, monolithic_at(1e-11), monolithic_at(1e-10), diagram);
    diagram.reference = "the monolithic method at relative tolerance 1e-11";
  } catch (const InputError&) {
    subject.multipole = false;
    subject.field_tolerance = 1e-10;
    find_reference(subject, split_at(1e-7, subject.radius), split_at(1e-6, subject.radius), diagram);
    diagram.reference = "the split method at position tolerance 1e-7 R";
  }
}

std::string describe_field(const MovingSubject& subject) {
  if (!subject.scene.effects.has(&EffectKind::field)) return "no field";
  if (subject.multipole) return fmt::format("field by the multipole method at tolerance {:g}", subject.field_tolerance);
  const FieldOptions& field = subject.scene.field();
  return fmt::format("field by the {} method on S = {} at tolerance {:g}", field.method->name, field.cells,
                     subject.field_tolerance);
}

}  // namespace

void sweep_time(const Scene& scene, const Request& request) {
  if (scene.dimension() == 3 || scene.domain.box().any_periodic())
    throw InputError(
        fmt::format("{}: work-precision compares positions in a closed plane domain: two dimensions and no periodic "
                    "side are allowed",
                    scene.path));
  MovingSubject subject{.scene = effects::with_field_chosen(scene), .radius = scene.smallest_radius()};
  choose(all_methods(subject), request);  // names are checked before anything is computed
  Diagram diagram{.quantities = {"positions"},
                  .measure = "the largest final distance of a conductor from the reference, in smallest radii",
                  .work = "field solves"};
  request.begin();
  choose_field(subject, diagram);
  diagram.title = fmt::format("motion of {} conductors over {:g} s, {} contacts made or lost; {}",
                              scene.conductors.size(), scene.stop.time, subject.contacts, describe_field(subject));
  request.serve(diagram, choose(all_methods(subject), request));
}

}  // namespace lichtenberg::work_precision
