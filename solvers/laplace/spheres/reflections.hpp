#pragma once

#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Reflection of a small conducting sphere (radius R_s) in a much larger one (R_L, distance d of the centres). The
/// large sphere would need a degree of the order of the ratio of radii. Its harmonics beyond its own degree respond to
/// the small sphere alone and are eliminated from the system (Schur complement). They reflect the small sphere's
/// multipoles a back to its local coefficients b: b -= W a.
/// With z from the large sphere to the small one, W is for each m the product of two translations:
///   W_tt' = (-1)^(t+t') R_s/R_L sum over l > degree of g_tl g_t'l,
///   g_tl = sqrt(C(l+t, l+m) C(l+t, l-m)) (R_L/d)^(l+1) (R_s/d)^t.
/// The remaining matrix stays symmetric and positive.
struct Reflection {
  int small = 0, large = 0;
  Vec3 displacement;           ///< Displacement from the large sphere (its periodic copy) to the small one (m)
  int degree = 0;              ///< Degree of the small sphere
  std::vector<double> factor;  ///< W, [m][t][t'], for Translation::in_pair_frame
};

/// Computes the matrix W of the reflection of a small sphere in a large one. `to_small`: the near pair with the small
/// sphere as its target.
Reflection reflection_of(const NearPair& to_small, const Site& small, const Site& large);

/// Applies a reflection: subtracts W a from the small sphere's local coefficients. W is the reflection's matrix, a are
/// the small sphere's multipoles. `multipoles` and `local` begin with the coefficients of the small sphere.
void add_reflection(const Reflection& reflection, const double* multipoles, double* local);
/// Applies a reflection to eight fields at once: subtracts W a from the small sphere's local coefficients. W is the
/// reflection's matrix, a are the small sphere's multipoles. `multipoles` and `local` begin with the coefficients of
/// the small sphere.
void add_reflection(const Reflection& reflection, const Lanes* multipoles, Lanes* local);

/// Largest ratio of radii for a reflection; the sum over l has about twenty times as many terms.
constexpr double largest_ratio = 1e4;

/// Computes an approximate upper bound of the interaction of two small spheres by harmonics beyond `degree` on their
/// large neighbour, which reflections omit. It is relative to the reflections of either sphere. `one`, `other`: the
/// near pairs with the small spheres as targets.
double omitted_interaction(const NearPair& one, const NearPair& other, const std::vector<Site>& sites, int degree);

/// Computes the force (over 4 pi eps) of the small sphere on the eliminated multipoles of the large sphere. It is
/// missing in the large sphere's force. It follows from the balance of the forces between the pair. `start`: index of
/// each sphere's first coefficient in `multipoles`.
Vec3 force_on_large(const Reflection& reflection, const std::vector<Site>& sites, const std::vector<int>& start,
                    const double* multipoles);

}  // namespace lichtenberg::laplace::spheres
