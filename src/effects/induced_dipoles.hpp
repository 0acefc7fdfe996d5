#pragma once

#include "solvers/periodic/dipoles.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
template <>
inline constexpr Named<periodic::DipoleSum> values_named<periodic::DipoleSum>[] = {
    {periodic::DipoleSum::ewald, "ewald"},
    {periodic::DipoleSum::mixed_consistent, "mixed-consistent"},
    {periodic::DipoleSum::minimum_image, "minimum-image"},
    {periodic::DipoleSum::source, "source"}};
}  // namespace lichtenberg

namespace lichtenberg::effects {

/// Options of dipoles that charges induce in other grains. The effect `coulomb` reads the options and computes the
/// dipoles, because charges and dipoles are summed together. Above degree 1 the solver of spheres replaces this sum
/// (solvers/laplace/spheres).
struct InducedDipolesOptions {
  double polarizability = 0.005;  ///< A, d0^3
  periodic::DipoleSum sum = periodic::DipoleSum::ewald;
  double tolerance = 1e-6;  ///< relative tolerance of the polarizing field
  /// Degree of the multipoles; above 1 grains are dielectric spheres of that polarizability
  int degree = 1;

  static constexpr int most = 60;  ///< largest degree

  /// Returns the permittivity, relative to the medium, of a sphere with that polarizability and `radius` (d0). It is
  /// infinite for a conductor.
  double relative_permittivity(double radius) const;

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
