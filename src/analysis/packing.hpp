#pragma once

#include <optional>
#include <vector>

#include "src/effects/contact_potential.hpp"
#include "src/model/bodies.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// A particle and what it presses on.
struct PackingContact {
  int particle = 0, partner = 0;  ///< partner: a particle of larger index or, from their number on, a wall
  double q = 0;                   ///< distance over reach
  double overlap = 0;             ///< m, reach - distance
  double force = 0;               ///< N, repulsive
};

/// A rattler touches the others only from below, and creeps towards q = 1 for ever: its contacts are none.
constexpr double contact_margin = 1e-9;

/// A static packing and what holds it.
struct Packing {
  std::vector<PackingContact> contacts;  ///< those with q < 1 - contact_margin, in ascending order
  std::vector<bool> rattler;             ///< [N]
  std::vector<double> wall_force;        ///< N, outward, on each wall
  double smallest_q = 1;

  int rattlers = 0;
  double coordination = 0;           ///< contacts of a particle on average, with walls too
  double backbone_coordination = 0;  ///< the same of those that are no rattlers, contacts with rattlers left out

  // Of a packing between the sides of its domain and no other wall.
  std::optional<double> fraction;         ///< area (volume) of the particles, overlaps counted twice, over the domain's
  std::optional<double> pressure;         ///< N/m (Pa): mean over the directions of the force on a side over its extent
  std::optional<double> virial_pressure;  ///< the same from the forces inside: equal at rest
};

/// A particle held by fewer than dimension + 1 contacts can move freely; without it, others may become rattlers.
Packing packing(const Bodies& bodies, const Scene& scene, const effects::ContactPotential& potential);

/// What of it a result file keeps, as the group "packing".
ColumnGroup columns_of(const Packing& packing);
/// What there is to say of it; no title.
Summary summarize(const Packing& packing, const Scene& scene);

}  // namespace lichtenberg::analysis
