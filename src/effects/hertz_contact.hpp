#pragma once

#include <optional>
#include <vector>

#include "src/effects/contact_losses.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/pair_effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Parameters of Hertz's elastic contact between spheres: elastic constants of the conductors.
struct HertzContactOptions {
  double young = 200e9;  ///< Young's modulus (Pa)
  double poisson = 0.3;  ///< Poisson's ratio
  ContactLosses losses{};
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: the constants above apply to all
  static const EffectKind& kind();
};

/// Effect of elastic contact of spheres, Hertz's repulsive force along the line of centres (Stephenson 2018, eq. 5.9),
/// with restitution and sliding friction (ContactLoss) if the scene has them.
class HertzContact : public PairEffect<HertzLaw> {
 public:
  explicit HertzContact(const HertzContactOptions& options);

  Needs needs() const override { return {.neighbour_range = 0.0, .largest_move = 0.5, .dissipates = loss_.any()}; }
  /// Adds the contact forces to `force` (N, [N * dimension]). Throws Failure if two spheres overlap by more than the
  /// smaller radius.
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  double dissipated_power(const State& state) const override;

 private:
  /// Returns the law with the contact modulus of the materials of this pair.
  HertzLaw law_of(Pair pair) const override {
    return bodies_.empty() ? law() : HertzLaw{contact_modulus(bodies_[pair.i], bodies_[pair.j])};
  }
  /// Calls visit(pair, loss) for each pair in contact with its LossForce on the first body.
  template <class Visit>
  void for_each_loss(const State& state, const Visit& visit) const;
  [[noreturn]] void refuse(const Bodies& bodies, Pair pair) const override;
  /// Adds the forces of all pairs, each with the contact modulus of its materials. Returns the first pair for which the
  /// law is not valid; empty if there is none.
  std::optional<Pair> add_forces_of_unlike(const State& state, std::span<double> force) const;

  std::vector<Elasticity> bodies_;  ///< material of each body; empty: the common material applies to all
  ContactLoss loss_;
};

}  // namespace lichtenberg::effects
