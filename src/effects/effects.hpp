#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/model/model.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns the descriptions of all built-in effects, in the order in which their contributions are added: those of
/// conductor_kinds() first.
const EffectKinds& all_kinds();

/// Returns the descriptions of the effects of conductors that a program without grains and packings has
/// (src/conductors.cpp).
EffectKinds conductor_kinds();

using EffectList = std::vector<std::unique_ptr<Effect>>;

/// Returns effects as a list for the argument `made` of make_model(); null pointers are left out.
template <class... E>
EffectList made(std::unique_ptr<E>... effects) {
  EffectList list;
  ((effects ? list.push_back(std::move(effects)) : void()), ...);
  return list;
}

/// Makes the model of a scene: its bodies, and the effects that have a table in the scene. Built-in effects come first,
/// in the order of all_kinds(), then others. `made`: effects that the caller has made to keep access to them.
///
/// Throws InputError if `made` has an effect that is not in the scene, or has an effect twice. Throws InputError if an
/// effect that is not in `made` exceeds its limits for a run (EffectKind::check_run). Throws InputError for an effect
/// that overrides a function which is never called for the bodies of the scene. Throws InputError for an effect of
/// grains with only one of add_forces() and stored_energy(). Throws InputError for a periodic box that is too short for
/// a neighbour list, and the exceptions of check_sharing().
Model make_model(const Scene& scene, EffectList made = {});

/// Makes the model of a scene without the effects that solve a field, for callers that have field results or need only
/// other effects. Throws the exceptions of make_model().
Model make_model_without_field(const Scene& scene);

/// Description of one effect, and of its use in a scene.
struct EffectSummary {
  std::string_view name;         ///< name of its table in the scene
  std::string_view description;  ///< one line
  bool in_scene = false;
  Needs needs;                                 ///< needs, if it is in the scene
  std::vector<ExplanationLine> explanation{};  ///< lines of `explain`, if it is in the scene
};

/// Returns descriptions of all built-in effects for this kind of scene (conductors or grains), in the order of
/// all_kinds(). Descriptions of other effects follow, if they are in the scene.
std::vector<EffectSummary> summarize_effects(const Scene& scene);

}  // namespace lichtenberg::effects
