#pragma once

#include <array>
#include <memory>
#include <optional>

#include "src/effects/wall_drag.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Options of Stokes drag.
struct StokesDragOptions {
  bool walls = false;                 ///< true: the drag is larger near the sides of the domain
  std::optional<double> roughness{};  ///< smallest gap (m) at which it grows; empty: 1e-3 of each radius
  static const EffectKind& kind();
};

/// Effect of Stokes drag on spheres, force F = -6 pi viscosity R v (Stokes 1851; Stephenson 2018, eq. 5.8). With
/// `walls` each side that is not periodic adds its part for a single plane wall: the force along an axis is multiplied
/// by 1 + sum of (factor - 1) over the sides. The factors are those of WallDrag for motion towards and along a side.
class StokesDrag : public Effect {
 public:
  /// Drag in a fluid without walls; `viscosity` in Pa s.
  explicit StokesDrag(double viscosity) : viscosity_(viscosity) {}
  /// Drag of a scene, which must have the effect.
  explicit StokesDrag(const Scene& scene);

  const EffectKind& kind() const override { return StokesDragOptions::kind(); }
  DragLaw drag(const Bodies& bodies, int body) const override;

 private:
  /// Sides of the domain that increase the drag of the bodies near them.
  struct Walls {
    Vec3 size;                        ///< lengths of the domain (m)
    std::array<bool, 6> is_wall{};    ///< in the order of side_names
    std::optional<double> roughness;  ///< m
    WallDrag factors;
  };
  double viscosity_;
  std::shared_ptr<const Walls> walls_;  ///< null: none
};

}  // namespace lichtenberg::effects
