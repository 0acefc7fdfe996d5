#include "src/effects/multipole_truncation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::effects {
namespace {

/// Returns the largest difference of the forces in two solutions, with multipoles to `degree` and to `higher`, over the
/// largest force in the second solution.
double difference_of_forces(const laplace::SphereProblem& problem, int degree, int higher, double tolerance) {
  const auto forces_at = [&](int l) {
    return laplace::SphereSolver({.accuracy = tolerance, .degree = l}).solve(problem).sphere_force;
  };
  const std::vector<Vec3> found = forces_at(degree), exact = forces_at(higher);
  double largest = 0, error = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    largest = std::max(largest, norm(exact[i]));
    error = std::max(error, norm(found[i] - exact[i]));
  }
  return largest > 0 ? error / largest : 0;
}

/// Returns the relative error of the force between two touching equal spheres of opposite charge. Multipole
/// coefficients of degree l near a contact decay like exp(-2 sqrt(l (-ln k))), k = (eps_r - 1) / (eps_r + 1)
/// (docs/numerics/spheres.md). With 100 more degrees the error of the second solution is negligible.
double error_in_contact(double radius, double permittivity, const InducedDipolesOptions& options) {
  laplace::SphereProblem problem{.free_space = true, .permittivity = 1 / (4 * std::numbers::pi)};
  for (const int i : {0, 1}) {
    problem.spheres.push_back({{2 * radius * i, 0, 0}, radius, i, permittivity});
    problem.groups.push_back({.charge = i == 0 ? 1.0 : -1.0});
  }
  return difference_of_forces(problem, options.degree, options.degree + 100, 1e-6);
}

}  // namespace

laplace::SphereProblem dielectric_spheres(const InducedDipolesOptions& options, const Bodies& bodies) {
  const bool free = std::ranges::all_of(bodies.box.sides, [](Boundary side) { return side == Boundary::wall; });
  laplace::SphereProblem problem{.box = bodies.box, .free_space = free, .permittivity = 1 / (4 * std::numbers::pi)};
  for (int i = 0; i < bodies.size(); ++i) {
    problem.spheres.push_back(
        {position_in_space(bodies, i), bodies.radius[i], i, options.relative_permittivity(i, bodies.radius[i])});
    problem.groups.push_back({.charge = bodies.charge[i]});
  }
  return problem;
}

std::optional<MultipoleTruncation> multipole_truncation(const Scene& scene) {
  const auto& options = *scene.effects.find<InducedDipolesOptions>();
  const double radius = scene.smallest_radius();
  double permittivity = 0;
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const double r = scene.conductors[i].radius;
    if (options.of(i) >= std::pow(r, 3)) return {};
    permittivity = std::max(permittivity, options.relative_permittivity(i, r));
  }
  MultipoleTruncation truncation{.in_contact = error_in_contact(radius, permittivity, options)};
  const int higher = 2 * options.degree + 4;
  constexpr double most_unknowns = 1e5;
  if (options.degree == 1 || static_cast<double>(scene.conductors.size()) * std::pow(higher + 1, 2) > most_unknowns)
    return truncation;
  Bodies bodies = make_bodies(scene);
  bodies.charge = initial_charges(scene);
  truncation.at_start =
      difference_of_forces(dielectric_spheres(options, bodies), options.degree, higher, options.tolerance);
  return truncation;
}

}  // namespace lichtenberg::effects
