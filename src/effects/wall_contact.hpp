#pragma once

#include <vector>

#include "src/effects/contact_losses.hpp"
#include "src/effects/hertz.hpp"
#include "src/effects/surface.hpp"
#include "src/model/effect.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Parameters of the elastic contact of spheres with walls: elastic constants of the walls and of the conductors.
struct WallContactOptions {
  double young = 200e9;  ///< Young's modulus of the walls (Pa)
  double poisson = 0.3;  ///< Poisson's ratio of the walls
  ContactLosses losses{};
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: all have one material
  static const EffectKind& kind();
};

/// Effect of Hertz's elastic contact of spheres with walls: the sides of the domain that are not periodic, and the
/// electrodes. The force of a ring electrode points inward. An unbounded domain has no sides.
class WallContact : public Effect {
 public:
  explicit WallContact(const Scene& scene);  ///< `scene` must have the table [effects.wall_contact]

  const EffectKind& kind() const override { return WallContactOptions::kind(); }
  Needs needs() const override { return {.largest_move = 0.5, .dissipates = loss_.any()}; }
  /// Adds the contact forces of walls to `force` (N, [N * dimension]). Throws Failure if the centre of a sphere is
  /// inside a wall.
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  double dissipated_power(const State& state) const override;
  void mark_interacting(const Bodies& bodies, std::span<const double> travel,
                        std::vector<bool>& interacting) const override;

 private:
  LossForce loss(const Bodies& bodies, int i, const View& seen, const HertzForce& elastic) const {
    return loss_(elastic, bodies.mass[i], seen.normal, velocity_in_space(bodies, i));
  }
  double modulus(int i) const { return modulus_.size() == 1 ? modulus_.front() : modulus_[i]; }
  /// Returns true if body i may touch a wall while it moves by at most `travel` (m).
  bool reaches(const Bodies& bodies, int i, double travel) const;
  /// Calls visit(i, view, force) for every contact of a requested body i with a wall: local geometry of the wall (View)
  /// and Hertz's force (HertzForce).
  template <class Visit>
  void for_each_contact(const State& state, Visit visit) const;

  /// Contact modulus E* (Pa) of each sphere with a wall; a single value holds for all spheres
  std::vector<double> modulus_;
  ContactLoss loss_;
  std::vector<Surface> walls_;
  // Cache that does not affect results: by body, the gap (m) to the nearest wall and the position at its last
  // computation. The gap has decreased since by at most the body's displacement.
  mutable std::vector<double> gap_, cached_position_;
};

}  // namespace lichtenberg::effects
