#pragma once

#include <vector>

#include "src/effects/hertz.hpp"
#include "src/effects/surface.hpp"
#include "src/model/effect.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct WallContactOptions {
  double young = 200e9;  ///< Pa, Young's modulus of the walls
  double poisson = 0.3;
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: no conductor has keys of its own
  static const EffectKind& kind();
};

/// Elastic contact of spheres with fixed bodies: the flat sides of the domain, except for periodic ones, and the
/// electrodes. The force of a ring points inward.
class WallContact : public Effect {
 public:
  explicit WallContact(const Scene& scene);  ///< `scene` must have the effect

  const EffectKind& kind() const override { return WallContactOptions::kind(); }
  Needs needs() const override { return {.largest_move = 0.5}; }
  /// Throws Failure if a body's centre is in a wall.
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  void mark_interacting(const Bodies& bodies, std::span<const double> travel,
                        std::vector<bool>& interacting) const override;

 private:
  double modulus(int i) const { return modulus_.size() == 1 ? modulus_.front() : modulus_[i]; }
  bool reaches(const Bodies& bodies, int i, double travel) const;
  template <class Visit>
  void for_each_contact(const State& state, Visit visit) const;

  /// Pa, E* of each sphere and a wall; one value holds for all spheres
  std::vector<double> modulus_;
  std::vector<Surface> walls_;
  // Cache that does not affect results: by body, the gap (m) to the nearest wall and the position at its last
  // computation. The gap has decreased since by at most the body's displacement.
  mutable std::vector<double> gap_, cached_position_;
};

}  // namespace lichtenberg::effects
