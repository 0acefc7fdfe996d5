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

struct SoftRepulsionOptions {
  double stiffness = 1;  ///< J
  static const EffectKind& kind();
};

/// Overlap of two particles, or of a particle and a wall.
struct Overlap {
  /// partner: a particle of larger index, or a wall, whose indices start at the number of particles
  int particle = 0, partner = 0;
  double q = 1;  ///< distance over `reach`, 0 < q < 1
  /// m; distance: between the centres, or of the centre from the wall; reach: sum of radii, or radius
  double distance = 0, reach = 0;
  std::array<double, 3> normal{};  ///< unit vector from the partner to the particle
};

/// Soft repulsion U = stiffness * sum of (q - 1) ln q over all overlapping pairs and all overlaps of particles with
/// walls, each once. The source's double sum counts every pair twice and includes self-overlaps. Walls would then have
/// half the stiffness of particles, and the rest positions would differ. The distance from a wall is signed: a particle
/// beyond a wall has infinite energy and no outward force. Two or three dimensions.
class SoftRepulsion : public Effect {
 public:
  /// Makes the effect. `stiffness`: factor of the potential (J).
  SoftRepulsion(double stiffness, std::vector<Wall> walls) : stiffness_(stiffness), walls_(std::move(walls)) {}
  /// `scene` must have the effect.
  explicit SoftRepulsion(const Scene& scene)
      : SoftRepulsion(scene.effects.find<SoftRepulsionOptions>()->stiffness, scene.walls) {}

  const EffectKind& kind() const override { return SoftRepulsionOptions::kind(); }
  Needs needs() const override { return {.neighbour_range = 0.0}; }

  /// Returns U (J); infinite if two centres coincide, or if a centre is on or beyond a wall.
  double energy(const State& state) const;
  /// Returns U (J) and adds the forces. If U is infinite, only some forces are added.
  double energy_and_forces(const State& state, std::span<double> force) const;
  /// Returns the part of U, and adds its forces, of pairs whose first particle is from `first` to before `end`, and of
  /// these particles and the walls. Callers can divide the particles among threads. The function changes `force` of
  /// these particles only and appends the forces on other particles to `outside_forces`.
  double energy_and_forces(const State& state, int first, int end, std::span<double> force,
                           std::vector<ParticleForce>& outside_forces) const;
  /// Throws Failure if the energy is infinite.
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;

  /// Returns all overlaps: pairs in the order of the neighbours, then walls in their order. Empty if the energy is
  /// infinite.
  std::vector<Overlap> overlaps(const State& state) const;
  /// Returns the overlaps of pairs whose first particle is from `first` to before `end`, in the order of particles, and
  /// then of these particles and the walls.
  std::vector<Overlap> overlaps(const State& state, int first, int end) const;

  double stiffness() const { return stiffness_; }
  const std::vector<Wall>& walls() const { return walls_; }

 private:
  template <int dimension>
  double range_energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                 std::vector<ParticleForce>& outside_forces) const;
  template <int dimension>
  bool add_walls(const State& state, int first, int end, std::span<double> force, double& sum) const;

  ContactPotentialLaw law() const { return {stiffness_}; }

  double stiffness_;  ///< J
  std::vector<Wall> walls_;
};

}  // namespace lichtenberg::effects
