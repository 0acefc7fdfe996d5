#pragma once

#include <optional>

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::effects {

/// Charged grains as dielectric spheres of the options' polarizability, in units with 4 pi eps = 1.
laplace::SphereProblem dielectric_spheres(const InducedDipolesOptions& options, const Bodies& bodies);

/// Errors of forces that effects.induced_dipoles.degree alone makes, beside solutions of a higher degree.
struct MultipoleTruncation {
  /// The largest error over the largest force at the start. Empty for degree 1, which has no sphere problem, and where
  /// the solution of higher degree would take more than some seconds.
  std::optional<double> at_start;
  double in_contact = 0;  ///< of the attraction of two opposite charges on touching grains of the smallest radius
};

/// Empty where grains are as polarizable as conductors, and so no dielectric spheres. Throws InputError for grains that
/// laplace::SphereSolver refuses.
std::optional<MultipoleTruncation> multipole_truncation(const Scene& scene);

}  // namespace lichtenberg::effects
