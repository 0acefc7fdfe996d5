// The field of spheres in space: error against time by accuracy and by degree.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/spheres.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/output.hpp"
#include "src/commands/work_precision.hpp"

namespace lichtenberg::work_precision {
namespace {

/// Compared quantities of a field of spheres.
struct SphereAnswer {
  std::vector<double> potential;  ///< V, of each group
  std::vector<double> charge;     ///< C, of each sphere
  std::vector<Vec3> force;        ///< N, of each sphere
};

struct SphereSubject {
  laplace::SphereProblem problem;
  SphereAnswer reference;

  /// Returns true if some charges are unknown.
  bool has_unknown_charges() const;
  /// Returns the largest errors of potentials, forces and, if some are unknown, charges, each relative to the largest
  /// magnitude in the reference.
  std::vector<double> errors(const SphereAnswer& answer) const;
};

using Json = nlohmann::ordered_json;

SphereAnswer answer_of(const laplace::SphereSolution& solution) {
  return {solution.group_potential, solution.sphere_charge, solution.sphere_force};
}

/// Trial: a solve without an initial guess from earlier solves.
class SphereTrial : public Trial {
 public:
  SphereTrial(const SphereSubject& subject, const laplace::SphereOptions& options)
      : subject_(subject), solver_(options) {}

  void run() override {
    solver_.forget();
    solution_ = solver_.solve(subject_.problem);
  }
  std::vector<double> errors() const override { return subject_.errors(answer_of(solution_)); }
  std::int64_t work() const override { return solution_.iterations; }

 private:
  const SphereSubject& subject_;
  laplace::SphereSolver solver_;
  laplace::SphereSolution solution_;
};

Method by_accuracy(const SphereSubject& subject) {
  Method method{"spheres", "degrees from the accuracy and the neighbours of each sphere, gaps exact", {}};
  for (int decade = 1; decade <= 10; ++decade) {
    const double accuracy = std::pow(10, -decade);
    method.candidates.push_back({{{"accuracy", accuracy}}, std::pow(decade, 3), [&subject, accuracy] {
                                   return std::make_unique<SphereTrial>(subject,
                                                                        laplace::SphereOptions{.accuracy = accuracy});
                                 }});
  }
  return method;
}

/// Returns the sweep over degrees. The lattice sum and the iteration are much more accurate than the truncation.
Method by_degree(const SphereSubject& subject) {
  Method method{"spheres-degree", "all spheres to one degree, gaps as all else; 1: dipoles", {}};
  for (const int degree : {1, 2, 4, 8, 16, 32})
    method.candidates.push_back({{{"degree", degree}}, std::pow(degree, 3), [&subject, degree] {
                                   return std::make_unique<SphereTrial>(
                                       subject, laplace::SphereOptions{.accuracy = 1e-10, .degree = degree});
                                 }});
  return method;
}

std::vector<Method> all_methods(const SphereSubject& subject) { return {by_accuracy(subject), by_degree(subject)}; }

/// Computes the reference at the smallest feasible accuracy. The change at ten times that accuracy bounds its error.
void find_reference(SphereSubject& subject, Diagram& diagram) {
  for (double accuracy = 1e-12;; accuracy *= 10) {
    try {
      subject.reference = answer_of(laplace::SphereSolver({.accuracy = accuracy}).solve(subject.problem));
      diagram.reference_errors =
          subject.errors(answer_of(laplace::SphereSolver({.accuracy = 10 * accuracy}).solve(subject.problem)));
      diagram.reference = fmt::format("the spheres' own harmonics at accuracy {:g}", accuracy);
      return;
    } catch (const InputError&) {
      if (accuracy > 1e-4) throw;
    }
  }
}

std::vector<double> SphereSubject::errors(const SphereAnswer& answer) const {
  const auto relative = [](const auto& found, const auto& exact, const auto& size) {
    double error = 0, largest = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const double one = k < found.size() ? size(found[k] - exact[k]) : NAN;
      if (!(one <= error)) error = one;  // NaN is kept
      largest = std::max(largest, size(exact[k]));
    }
    return largest > 0 ? error / largest : error;
  };
  const auto magnitude = [](double value) { return std::abs(value); };
  std::vector<double> all = {relative(answer.potential, reference.potential, magnitude),
                             relative(answer.force, reference.force, [](Vec3 v) { return norm(v); })};
  if (has_unknown_charges()) all.push_back(relative(answer.charge, reference.charge, magnitude));
  return all;
}

bool SphereSubject::has_unknown_charges() const {
  return problem.spheres.size() > problem.groups.size() ||
         std::ranges::any_of(problem.groups, [](const laplace::Group& group) { return !group.floating; });
}

/// Returns the description for other programs' methods.
Json described(const laplace::SphereProblem& problem) {
  Json json{{"box", components(problem.box.lengths)},
            {"permittivity", problem.permittivity},
            {"closed", !problem.free_space && !problem.box.any_periodic()},
            {"ground", problem.has_ground()},
            {"dielectrics", !std::ranges::all_of(problem.spheres, &laplace::Sphere::is_conductor)}};
  for (int side = 0; side < 6; ++side)
    json["side_potential"].push_back(problem.box.sides[side] == Boundary::electrode ? Json(problem.side_potential[side])
                                                                                    : Json());
  for (const laplace::Sphere& sphere : problem.spheres)
    json["spheres"].push_back(
        {{"centre", components(sphere.centre)}, {"radius", sphere.radius}, {"group", sphere.group}});
  for (const laplace::Group& group : problem.groups)
    json["groups"].push_back({{"floating", group.floating}, {"charge", group.charge}, {"potential", group.potential}});
  return json;
}

/// Reads an answer. A charge of null is unknown.
SphereAnswer answer_of(const Json& json) {
  SphereAnswer answer{.potential = json.at("potential"), .charge = {}, .force = {}};
  for (const Json& charge : json.at("charge")) answer.charge.push_back(charge.is_null() ? NAN : charge.get<double>());
  for (const Json& force : json.at("force")) answer.force.push_back({force.at(0), force.at(1), force.at(2)});
  return answer;
}

}  // namespace

void sweep_spheres(const Scene& scene, const Request& request) {
  if (!request.sizes.empty())
    throw InputError("--sizes is for methods with a grid: the field of spheres in three dimensions has none");
  check_side_potentials(scene);
  SphereSubject subject{.problem = make_field_problem(scene).spheres, .reference = {}};
  subject.problem.check();
  const std::vector<Method> methods = choose(all_methods(subject), request);
  Diagram diagram{.title = fmt::format("field of {} spheres in {} groups", subject.problem.spheres.size(),
                                       subject.problem.groups.size()),
                  .quantities = {"potentials", "forces"},
                  .measure = "the largest of all spheres, relative to the largest potential, force or charge",
                  .work = "iterations"};
  if (subject.has_unknown_charges()) diagram.quantities.emplace_back("charges");
  request.begin();
  find_reference(subject, diagram);
  diagram.subject = [&] { return described(subject.problem); };
  diagram.errors = [&](const Json& answer) { return subject.errors(answer_of(answer)); };
  request.serve(diagram, methods);
}

}  // namespace lichtenberg::work_precision
