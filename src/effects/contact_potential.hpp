#pragma once

#include <array>
#include <span>
#include <vector>

#include "src/effects/contact_law.hpp"
#include "src/model/effect.hpp"
#include "src/model/pair_loop.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct ContactPotentialOptions {
  double stiffness = 1;  ///< J
  static const EffectKind& kind();
};

/// Two particles that overlap, or a particle and a wall.
struct Overlap {
  int particle = 0, partner = 0;   ///< partner: a particle of larger index or, from their number on, a wall
  double q = 1;                    ///< distance over `reach`, 0 < q < 1
  double distance = 0, reach = 0;  ///< m: of the centres, or of the centre from the wall; sum of radii, or radius
  std::array<double, 3> normal{};  ///< from the partner to the particle
};

/// U = stiffness * sum of (q - 1) ln q over all pairs and all particles and walls that overlap, each once. (In the
/// source's double sum every pair stands twice and every particle overlaps itself; walls would then be half as stiff
/// as particles, and particles would rest elsewhere.) The distance from a wall keeps its sign: what is beyond a wall
/// has infinite energy, and is not pushed outward. Two dimensions or three.
class ContactPotential : public Effect {
 public:
  /// stiffness: k, J.
  ContactPotential(double stiffness, std::vector<Wall> walls) : stiffness_(stiffness), walls_(std::move(walls)) {}
  explicit ContactPotential(const Scene& scene)  ///< which has it
      : ContactPotential(scene.effects.find<ContactPotentialOptions>()->stiffness, scene.walls) {}

  const EffectKind& kind() const override { return ContactPotentialOptions::kind(); }
  Needs needs() const override { return {.neighbour_range = 0.0}; }

  /// U in J; infinite if a centre lies on another or on or beyond a wall.
  double energy(const State& state) const;
  /// U in J, and adds the forces; if it is infinite, only some of them.
  double energy_and_forces(const State& state, std::span<double> force) const;
  /// The share of U, with its forces, of the pairs whose first particle is one from `first` on up to before `end`, and
  /// of these particles and the walls: for who shares the particles among threads. Touches `force` of no other
  /// particles; what acts on those is appended to `beyond`.
  double energy_and_forces(const State& state, int first, int end, std::span<double> force,
                           std::vector<Push>& beyond) const;
  /// Throws Failure where the energy is infinite.
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;

  /// Everything that overlaps: pairs in the order of the neighbours, then wall by wall. Empty if the
  /// energy is infinite.
  std::vector<Overlap> overlaps(const State& state) const;
  /// The overlaps of the pairs whose first particle is one from `first` on up to before `end`, particle by particle,
  /// and then of these particles and the walls.
  std::vector<Overlap> overlaps(const State& state, int first, int end) const;

  double stiffness() const { return stiffness_; }
  const std::vector<Wall>& walls() const { return walls_; }

 private:
  template <int dimension>
  double range_energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                 std::vector<Push>& beyond) const;
  template <int dimension>
  bool add_walls(const State& state, int first, int end, std::span<double> force, double& sum) const;

  ContactPotentialLaw law() const { return {stiffness_}; }

  double stiffness_;  ///< J
  std::vector<Wall> walls_;
};

}  // namespace lichtenberg::effects
