#pragma once

#include <optional>

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::effects {

/// Returns the field problem of charged grains as dielectric spheres of the given polarizability, in units with 4 pi
/// eps = 1 (eps: permittivity of the medium). If all sides are insulating, the spheres are in free space.
laplace::SphereProblem dielectric_spheres(const InducedDipolesOptions& options, const Bodies& bodies);

/// Relative errors of forces due to truncation of the multipole expansions at effects.induced_dipoles.degree. They are
/// estimated by solutions of a higher degree.
struct MultipoleTruncation {
  /// Largest error of a force over the largest force at the start. Empty for degree 1, which has no sphere problem, and
  /// if the solution of higher degree would have more than 1e5 unknowns.
  std::optional<double> at_start;
  /// Relative error of the attraction of opposite charges on two smallest grains in contact
  double in_contact = 0;
};

/// Estimates the truncation errors of the multipole expansions for a scene. Empty if the smallest grains are at least
/// as polarizable as conductors, so that no dielectric sphere has their polarizability. Throws the exceptions of
/// laplace::SphereSolver::solve.
std::optional<MultipoleTruncation> multipole_truncation(const Scene& scene);

}  // namespace lichtenberg::effects
