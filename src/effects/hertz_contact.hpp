#pragma once

#include <optional>
#include <vector>

#include "src/effects/hertz.hpp"
#include "src/model/effect.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct HertzContactOptions {
  double young = 200e9;  ///< Pa
  double poisson = 0.3;
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: all have the constants above
  static const EffectKind& kind();
};

/// Elastic spheres push each other apart along the line of their centres, without friction (D 5.4.2, 5.9).
class HertzContact : public Effect {
 public:
  explicit HertzContact(const HertzContactOptions& options);

  const EffectKind& kind() const override { return HertzContactOptions::kind(); }
  Needs needs() const override { return {.neighbour_range = 0.0, .largest_move = 0.5}; }
  /// Throws Failure if two overlap by more than a radius.
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  void mark_pushed(const Bodies& bodies, std::span<const double> travel, std::vector<bool>& pushed) const override;

 private:
  /// The law with the modulus of this pair's materials.
  HertzLaw law(Pair pair) const {
    return bodies_.empty() ? HertzLaw{modulus_} : HertzLaw{contact_modulus(bodies_[pair.i], bodies_[pair.j])};
  }
  std::optional<Pair> add_forces_of_unlike(const State& state, std::span<double> force) const;

  double modulus_;                  ///< Pa, E* of two bodies of the common material
  std::vector<Elasticity> bodies_;  ///< material of each body; empty: all have the common one
  mutable ReachList near_;          ///< makes looks faster, and changes no answer
};

}  // namespace lichtenberg::effects
