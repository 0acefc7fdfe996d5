#pragma once

#include <array>
#include <span>
#include <vector>

#include "src/effects/contact_law.hpp"
#include "src/model/effect.hpp"
#include "src/model/pair_loop.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

template <>
inline constexpr Named<effects::RepulsionForm> values_named<effects::RepulsionForm>[] = {
    {effects::RepulsionForm::logarithmic, "logarithmic"},
    {effects::RepulsionForm::harmonic, "harmonic"},
    {effects::RepulsionForm::hertzian, "hertzian"}};

namespace effects {

/// Parameters of the soft repulsion of packings: factor and form of its potential energy.
struct SoftRepulsionOptions {
  double stiffness = 1;  ///< factor of the potential energy (J)
  RepulsionForm form = RepulsionForm::logarithmic;
  static const EffectKind& kind();
};

/// Returns the unit of pressure of a packing, stiffness / D^d with the mean diameter D and the dimension d (N/m, in
/// space Pa).
double pressure_unit(const Scene& scene);

/// Returns the lowest pressure (N/m, in space Pa) that net forces up to minimize.force_tolerance do not hide: 100
/// of these, in pressure_unit().
double lowest_pressure(const Scene& scene);

/// Geometry of an overlap of two particles, or of a particle and a wall.
struct Overlap {
  /// partner: index of a particle of larger index, or number of particles + index of a wall
  int particle = 0, partner = 0;
  double q = 1;  ///< distance over `reach`, 0 < q < 1
  /// m; distance: between the centres, or of the centre from the wall; reach: sum of the radii, or the radius
  double distance = 0, reach = 0;
  std::array<double, 3> normal{};  ///< unit vector from the partner to the particle
};

/// Effect of soft repulsion in packings. The potential energy U is the sum of stiffness * w(q) over all overlaps, by
/// default with w(q) = (q - 1) ln q. For two particles, q is the distance of the centres over the sum of the radii. For
/// a particle and a wall, q is the distance of the centre from the wall over the radius. A particle whose centre is on
/// or beyond a wall has infinite energy. Two or three dimensions.
///
/// Each overlap counts once. The source (docs/theory/packings.md) counts each pair of particles twice, so that walls
/// have half of the stiffness of particles and the rest positions differ.
class SoftRepulsion : public Effect {
 public:
  SoftRepulsion(const SoftRepulsionOptions& options, std::vector<Wall> walls)
      : options_(options), walls_(std::move(walls)) {}
  /// Makes the effect of a scene, which must have the table [effects.soft_repulsion].
  explicit SoftRepulsion(const Scene& scene)
      : SoftRepulsion(*scene.effects.find<SoftRepulsionOptions>(), scene.walls) {}

  const EffectKind& kind() const override { return SoftRepulsionOptions::kind(); }
  Needs needs() const override { return {.neighbour_range = 0.0}; }

  /// Returns the potential energy U (J) of all overlaps; infinite if two centres coincide, or if a centre is on or
  /// beyond a wall.
  double energy(const State& state) const;
  /// Returns the potential energy U (J) of all overlaps and adds their forces to `force` (N, [N * dimension]). If U is
  /// infinite, only some forces are added.
  double energy_and_forces(const State& state, std::span<double> force) const;
  /// Returns the potential energy (J) of some overlaps and adds their forces, for callers that divide the particles
  /// among threads. These are the pairs whose first particle i is in first <= i < end, and the overlaps of these
  /// particles with walls. Forces on these particles are added to `force`, and forces on others are appended to
  /// `outside_forces`.
  double energy_and_forces(const State& state, int first, int end, std::span<double> force,
                           std::vector<ParticleForce>& outside_forces) const;
  /// Adds the forces of all overlaps to `force` (N, [N * dimension]). Throws Failure if the energy is infinite.
  void add_forces(const State& state, std::span<double> force) const override;
  void add_jacobian(const State& state, ForceJacobian& jacobian) const override;

  /// Returns all overlaps: pairs of particles in the order of State::neighbours, then overlaps with each wall in the
  /// order of the walls. Empty if the energy is infinite.
  std::vector<Overlap> overlaps(const State& state) const;
  /// Returns the overlaps of pairs whose first particle i is in first <= i < end, in the order of State::neighbours,
  /// then overlaps of these particles with each wall. Empty if the energy of these overlaps is infinite.
  std::vector<Overlap> overlaps(const State& state, int first, int end) const;

  double stiffness() const { return options_.stiffness; }
  RepulsionForm form() const { return options_.form; }
  /// Returns w(q) and its first two derivatives for 0 < q <= 1.
  ContactLaw contact(double q) const { return contact_law(options_.form, q); }
  const std::vector<Wall>& walls() const { return walls_; }

 private:
  template <int dimension>
  double range_energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                 std::vector<ParticleForce>& outside_forces) const;
  template <int dimension>
  bool add_walls(const State& state, int first, int end, std::span<double> force, double& sum) const;

  ContactPotentialLaw law() const { return {options_.stiffness, options_.form}; }

  SoftRepulsionOptions options_;
  std::vector<Wall> walls_;
};

}  // namespace effects
}  // namespace lichtenberg
