#pragma once

#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// A small conducting sphere beside a much larger one calls for harmonics on the large one that go with the ratio of
/// radii. Those beyond the large one's degree answer to the small one alone: eliminated from the system they are a
/// reflection of the small one's multipoles back to it, b -= W a. With z from the large sphere to the small one, for
/// each m
///
///   W_tt' = (-1)^(t+t') R_s/R_L sum over l > degree of g_tl g_t'l,
///   g_tl = sqrt(C(l+t, l+m) C(l+t, l-m)) (R_L/d)^(l+1) (R_s/d)^t,
///
/// which is the product of the two translations. What is left of the matrix stays symmetric and positive (Schur's
/// complement).
struct Reflection {
  int small = 0, large = 0;
  Vec3 way;                    ///< from the large sphere (its periodic copy) to the small one
  int degree = 0;              ///< of the small one
  std::vector<double> factor;  ///< W, [m][t][t'], as Translation::in_pair_frame takes it
};

/// `to_small` is the pair with the small sphere as its target.
Reflection reflection_of(const NearPair& to_small, const Site& small, const Site& large);

/// Takes W a of the small sphere off its local coefficients.
void add_reflection(const Reflection& reflection, const double* multipoles, double* local);
void add_reflection(const Reflection& reflection, const Lanes* multipoles, Lanes* local);

/// Largest ratio of radii: the sum over l has some twenty times as many terms.
constexpr double largest_ratio = 1e4;

/// Returns a bound on what harmonics beyond `degree` on the large sphere carry from one small sphere to another, over
/// what is on either. `one` and `other`: the pairs with the small ones as targets.
double carried_beyond(const NearPair& one, const NearPair& other, const std::vector<Site>& sites, int degree);

/// N / (4 pi eps), what the large sphere's force lacks: that of the small one on its eliminated multipoles. The pair's
/// forces on each other are opposite.
Vec3 force_on_large(const Reflection& reflection, const std::vector<Site>& sites, const std::vector<int>& start,
                    const double* multipoles);

}  // namespace lichtenberg::laplace::spheres
