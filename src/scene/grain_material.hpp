#pragma once

namespace lichtenberg {

/// Material of a grain relative to that of the scene. Contact constants of a pair follow from both materials, as
/// those of springs in series.
struct GrainMaterial {
  double density = 1;
  double stiffness = 1;  ///< of the contact of two such grains
  double damping = 1;    ///< ratio of damping to stiffness (viscous time) of that contact

  bool operator==(const GrainMaterial&) const = default;
};

}  // namespace lichtenberg
