#pragma once

#include <optional>
#include <vector>

#include "src/effects/soft_repulsion.hpp"
#include "src/model/bodies.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Contact of a particle of a packing with another particle or a wall.
struct PackingContact {
  /// Indices; `partner` is a particle of larger index, or a wall, whose indices start at the number of particles
  int particle = 0, partner = 0;
  double q = 0;        ///< distance over the sum of radii (particles) or the radius (wall)
  double overlap = 0;  ///< m, contact distance minus distance
  double force = 0;    ///< N, repulsive
};

/// Margin below q = 1 (distance over contact distance) within which a contact does not count: contacts of rattlers
/// approach q = 1 from below without reaching it.
constexpr double contact_margin = 1e-9;

/// Properties of a static packing: contacts, rattlers, coordination numbers and pressure.
struct Packing {
  std::vector<PackingContact> contacts;  ///< contacts with q < 1 - contact_margin, in ascending order
  std::vector<bool> rattler;             ///< [N]
  std::vector<double> wall_force;        ///< N, outward, on each wall
  double smallest_q = 1;

  int rattlers = 0;
  double coordination = 0;  ///< coordination number: mean number of contacts of a particle, including walls
  /// Coordination number without rattlers and their contacts
  double backbone_coordination = 0;

  // Only for a packing between the sides of its domain without other walls:
  /// Packing fraction: area (volume) of the particles over that of the domain, overlaps counted twice
  std::optional<double> fraction;
  /// Pressure (N/m, in space Pa): force on a side over its extent, averaged over the directions
  std::optional<double> pressure;
  /// Pressure (N/m, in space Pa) by the virial of the contact forces; equal to `pressure` at rest
  std::optional<double> virial_pressure;
};

/// Computes the contacts, rattlers, coordination numbers and pressure of a packing at the bodies' positions. A particle
/// with fewer than dimension + 1 contacts counts as a rattler. Its contacts are then removed, which can make other
/// particles rattlers.
Packing packing(const Bodies& bodies, const Scene& scene, const effects::SoftRepulsion& potential);

/// Returns the contacts, rattlers and wall forces of a packing as columns of a result file, in the group "packing".
ColumnGroup columns_of(const Packing& packing);
/// Returns the summary of a packing (lines of text, quantities, warnings), without a title.
Summary summarize(const Packing& packing, const Scene& scene);

}  // namespace lichtenberg::analysis
