#pragma once

#include <cstddef>
#include <vector>

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

/// Parameters of the dipoles (or higher multipoles) that charges induce in other grains. The effect `coulomb` reads
/// them and computes the dipoles, because charges and dipoles are summed together. For multipoles of degree above 1,
/// the field solver of spheres replaces this sum (solvers/laplace/spheres).
struct InducedDipolesOptions {
  /// A (d0^3): dipole of a grain over the field at its centre; the largest one of a scene, if grains differ
  double polarizability = 0.005;
  std::vector<double> each{};  ///< A of each grain (d0^3); empty: they are equal
  periodic::DipoleSum sum = periodic::DipoleSum::ewald;
  double tolerance = 1e-6;  ///< relative tolerance of the polarizing field
  /// Degree of the multipoles; above 1 grains are dielectric spheres of this polarizability
  int degree = 1;

  static constexpr int most = 60;  ///< largest degree

  /// Returns A of a grain (d0^3).
  double of(std::size_t grain) const { return each.empty() ? polarizability : each[grain]; }
  /// Returns the dielectric constant (permittivity relative to the medium) of a grain, as a dielectric sphere of its
  /// polarizability A and `radius` R (d0): (R^3 + 2 A) / (R^3 - A). It diverges for A = R^3, a conductor.
  double relative_permittivity(std::size_t grain, double radius) const;

  static const EffectKind& kind();
};

}  // namespace lichtenberg::effects
