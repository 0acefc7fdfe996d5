#pragma once

#include <optional>

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::effects {

/// Returns charged grains as dielectric spheres of the options' polarizability, in units with 4 pi eps = 1.
laplace::SphereProblem dielectric_spheres(const InducedDipolesOptions& options, const Bodies& bodies);

/// Errors of forces due to effects.induced_dipoles.degree, estimated by solutions of a higher degree.
struct MultipoleTruncation {
  /// Largest error over the largest force at the start. Empty for degree 1, which has no sphere problem, and if the
  /// solution of higher degree would take more than a few seconds.
  std::optional<double> at_start;
  /// Relative error of the attraction of opposite charges on two smallest grains in contact
  double in_contact = 0;
};

/// Estimates the truncation errors. Empty if grains are as polarizable as conductors and thus no dielectric spheres.
/// Throws the exceptions of laplace::SphereSolver::solve.
std::optional<MultipoleTruncation> multipole_truncation(const Scene& scene);

}  // namespace lichtenberg::effects
