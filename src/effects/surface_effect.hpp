#pragma once

#include <functional>
#include <utility>

#include "src/model/effect.hpp"
#include "src/model/surface_law.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Effect that defines a part of the surface law of grains. The integrator of grains (src/granular/rough_motion.hpp)
/// computes the forces.
class SurfaceEffect : public Effect {
 public:
  /// `set`: sets the part of the law.
  SurfaceEffect(const EffectKind& kind, std::function<void(SurfaceLaw&)> set) : kind_(kind), set_(std::move(set)) {}

  const EffectKind& kind() const override { return kind_; }
  void set_surface(SurfaceLaw& law) const override { set_(law); }

 private:
  const EffectKind& kind_;
  std::function<void(SurfaceLaw&)> set_;
};

}  // namespace lichtenberg::effects
