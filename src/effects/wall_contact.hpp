#pragma once

#include <vector>

#include "src/effects/hertz.hpp"
#include "src/effects/surface.hpp"
#include "src/model/effect.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct WallContactOptions {
  double young = 200e9;  ///< Pa, of the walls
  double poisson = 0.3;
  std::vector<Elasticity> bodies{};  ///< material of each conductor; empty: no conductor has keys of its own
  static const EffectKind& kind();
};

/// The elastic contact of spheres with what does not move: the sides of the domain, which are flat, and the electrodes
/// (a ring pushes inward); not those that are periodic.
class WallContact : public Effect {
 public:
  explicit WallContact(const Scene& scene);  ///< which has it

  const EffectKind& kind() const override { return WallContactOptions::kind(); }
  Needs needs() const override { return {.largest_move = 0.5}; }
  /// Throws Failure if a body's centre is in a wall.
  void add_forces(const State& state, std::span<double> force) const override;
  double stored_energy(const State& state) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;
  void mark_pushed(const Bodies& bodies, std::span<const double> travel, std::vector<bool>& pushed) const override;

 private:
  double modulus(int i) const { return modulus_.size() == 1 ? modulus_.front() : modulus_[i]; }
  bool reaches(const Bodies& bodies, int i, double travel) const;
  template <class Visit>
  void for_each_contact(const State& state, Visit visit) const;

  std::vector<double> modulus_;  ///< Pa, E* of each sphere and a wall; one value holds for all spheres
  std::vector<Surface> walls_;
  // What makes looks faster, and changes no answer: by body, the gap (m) to the nearest wall at its last look, and
  // where that was. No wall is nearer than that by more than the body has moved since.
  mutable std::vector<double> gap_, looked_at_;
};

}  // namespace lichtenberg::effects
