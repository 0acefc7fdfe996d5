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

/// Charges polarize each other's grains. The effect `coulomb` reads these and computes it all, since charges and
/// dipoles are summed together; with higher multipoles the solver of spheres does that (solvers/laplace/spheres).
struct InducedDipolesOptions {
  double polarizability = 0.005;  ///< A, d0^3
  periodic::DipoleSum sum = periodic::DipoleSum::ewald;
  double tolerance = 1e-6;  ///< of the field that polarizes
  int degree = 1;           ///< of the multipoles; above 1 grains are dielectric spheres of that polarizability

  static constexpr int most = 60;  ///< degrees

  /// Of a sphere (d0) with that polarizability, over the permittivity outside; a conductor's is infinite.
  double relative_permittivity(double radius) const;

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
