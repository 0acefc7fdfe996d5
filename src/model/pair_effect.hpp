#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "src/model/effect.hpp"
#include "src/model/neighbours.hpp"
#include "src/model/pair_law_check.hpp"
#include "src/model/pair_loop.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Returns the largest gap (m) between the surfaces of two bodies at which a pair force law acts. It is 0 without
/// bodies or if the law acts only in contact. `radius`: radii of all bodies (m, [N]). The law's cutoff must be a convex
/// function of each radius, such as a sum or a maximum. The gap is then largest between bodies of extreme radii.
template <PairLaw Law>
double largest_gap(const Law& law, std::span<const double> radius) {
  if (radius.empty()) return 0;
  const auto [least, most] = std::ranges::minmax(radius);
  const auto gap = [&](double a, double b) { return law.reach(a, b) - (a + b); };
  return std::max({0.0, gap(least, least), gap(least, most), gap(most, most)});
}

/// Throws InputError if a pair force law contradicts itself for two bodies of this radius (m) and of charge 1
/// (pair_law_check.hpp). A law that acts beyond contact is checked there. `name`: name of the effect.
template <PairLaw Law>
void check_pair_law(const Law& law, double radius, const std::string& name) {
  const double reach = law.reach(radius, radius), contact = 2 * radius;
  const auto at = [&](double distance) {
    const PairGeometry pair{distance, reach, radius, radius, 1, 1};
    if constexpr (CanRefuse<Law>)
      if (law.refuses(pair)) return PairForce{};
    PairForce found = law(pair);
    found.energy *= law.energy_unit();
    if (Law::over_distance) found.force *= distance;
    return found;
  };
  check_pair_law(at, reach > contact ? contact : 0, reach, name);
}

/// Effect of a short-range pair force on conductors or grains. The pair force law (pair_law.hpp) gives the forces,
/// their energy and their derivatives. Pairs come from the neighbour list.
template <PairLaw Law>
class PairEffect : public Effect {
 public:
  /// Makes an effect from the law of its pair force. `radius`: radii of the bodies (m, [N]); empty for a law that acts
  /// in contact only.
  PairEffect(const EffectKind& kind, Law law, std::span<const double> radius)
      : kind_(&kind), law_(std::move(law)), gap_(largest_gap(law_, radius)) {}
  /// Makes an effect from the law of its pair force, for the radii of the scene's conductors. Throws InputError for a
  /// law that contradicts itself (check_pair_law).
  PairEffect(const EffectKind& kind, Law law, const Scene& scene)
      : PairEffect(kind, std::move(law), std::span<const double>(make_bodies(scene).radius)) {
    if (!scene.conductors.empty()) check_pair_law(law_, scene.smallest_radius(), kind.name);
  }

  const EffectKind& kind() const override { return *kind_; }
  Needs needs() const override { return {.charges = Law::charged, .neighbour_range = gap_}; }
  /// Adds the pair forces to `force` (N, [N * dimension]). Throws Failure if the law refuses a pair as not valid for
  /// it.
  void add_forces(const State& state, std::span<double> force) const override {
    const PairSum sum = visit_spheres(state.bodies, [&](const auto& spheres) {
      return add_pair_forces(law_, spheres, state.neighbours, force, state.team);
    });
    if (sum.refused) refuse(state.bodies, *sum.refused);
  }
  double stored_energy(const State& state) const override {
    double energy = 0;
    visit(state, [&](const auto& pair) {
      const Law law = law_of(pair.pair);
      energy += law.energy_unit() * law(pair.geometry).energy;
    });
    return energy;
  }
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override {
    visit(state, [&](const auto& pair) { add_pair_derivatives(law_of(pair.pair), pair, jacobian); });
  }
  void mark_interacting(const Bodies& bodies, std::span<const double> travel,
                        std::vector<bool>& interacting) const override {
    for (const Pair pair : pairs_within_reach(near_, bodies, gap_, travel))
      interacting[pair.i] = interacting[pair.j] = true;
  }

 protected:
  const Law& law() const { return law_; }
  /// Returns the law of one pair, for energy and derivatives. An effect whose law depends on the pair overrides this
  /// function and add_forces().
  virtual Law law_of(Pair pair) const { return (void)pair, law_; }
  /// Throws Failure for a pair that the law refuses as not valid for it.
  [[noreturn]] virtual void refuse(const Bodies& bodies, Pair pair) const {
    (void)bodies;
    throw Failure("effects." + std::string(name()) + ": its law does not hold between " + std::to_string(pair.i) +
                  " and " + std::to_string(pair.j));
  }

 private:
  template <class Visit>
  void visit(const State& state, const Visit& use) const {
    visit_spheres(state.bodies, [&](const auto& spheres) { for_each_in_reach(law_, spheres, state.neighbours, use); });
  }

  const EffectKind* kind_;
  Law law_;
  double gap_;              ///< m, largest gap between surfaces at which the law acts
  mutable ReachList near_;  ///< cache of mark_interacting; does not affect results
};

}  // namespace lichtenberg
