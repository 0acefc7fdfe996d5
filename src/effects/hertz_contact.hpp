#pragma once

#include <optional>
#include <vector>

#include "src/effects/hertz.hpp"
#include "src/model/pair_effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

struct HertzContactOptions {
  double young = 200e9;  ///< Pa
  double poisson = 0.3;
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: the constants above apply to all
  static const EffectKind& kind();
};

/// Frictionless elastic repulsion of spheres along the line of centres (D 5.4.2, 5.9).
class HertzContact : public PairEffect<HertzLaw> {
 public:
  explicit HertzContact(const HertzContactOptions& options);

  Needs needs() const override { return {.neighbour_range = 0.0, .largest_move = 0.5}; }
  /// Throws Failure if two spheres overlap by more than a radius.
  void add_forces(const State& state, std::span<double> force) const override;

 private:
  /// Returns the law with the modulus of this pair's materials.
  HertzLaw law_of(Pair pair) const override {
    return bodies_.empty() ? law() : HertzLaw{contact_modulus(bodies_[pair.i], bodies_[pair.j])};
  }
  [[noreturn]] void refuse(const Bodies& bodies, Pair pair) const override;
  std::optional<Pair> add_forces_of_unlike(const State& state, std::span<double> force) const;

  std::vector<Elasticity> bodies_;  ///< material of each body; empty: the common material applies to all
};

}  // namespace lichtenberg::effects
