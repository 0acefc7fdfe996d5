#pragma once

#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Reflection of a small conducting sphere in a much larger one. The large sphere would need a degree of the order of
/// the ratio of radii. Harmonics beyond its degree respond to the small sphere alone. Eliminated from the system, they
/// reflect the small sphere's multipoles back to it: b -= W a. With z from the large sphere to the small one, for each
/// m
///   W_tt' = (-1)^(t+t') R_s/R_L sum over l > degree of g_tl g_t'l,
///   g_tl = sqrt(C(l+t, l+m) C(l+t, l-m)) (R_L/d)^(l+1) (R_s/d)^t,
/// the product of the two translations. The remaining matrix, a Schur complement, stays symmetric and positive.
struct Reflection {
  int small = 0, large = 0;
  Vec3 displacement;           ///< Displacement from the large sphere (its periodic copy) to the small one
  int degree = 0;              ///< Degree of the small sphere
  std::vector<double> factor;  ///< W, [m][t][t'], for Translation::in_pair_frame
};

/// Makes the reflection; `to_small`: the pair with the small sphere as its target.
Reflection reflection_of(const NearPair& to_small, const Site& small, const Site& large);

/// Subtracts W a of the small sphere from its local coefficients.
void add_reflection(const Reflection& reflection, const double* multipoles, double* local);
void add_reflection(const Reflection& reflection, const Lanes* multipoles, Lanes* local);

/// Largest ratio of radii; the sum over l has about twenty times as many terms.
constexpr double largest_ratio = 1e4;

/// Returns a bound on the interaction of two small spheres by harmonics beyond `degree` on the large sphere, relative
/// to those on either. `one` and `other`: the pairs with the small spheres as targets.
double omitted_interaction(const NearPair& one, const NearPair& other, const std::vector<Site>& sites, int degree);

/// Returns the part missing in the large sphere's force (N / (4 pi eps)): the force of the small sphere on the
/// eliminated multipoles. The forces of the pair on each other are opposite.
Vec3 force_on_large(const Reflection& reflection, const std::vector<Site>& sites, const std::vector<int>& start,
                    const double* multipoles);

}  // namespace lichtenberg::laplace::spheres
