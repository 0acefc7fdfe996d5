#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/model/model.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Returns all built-in kinds of effects, in the order in which their contributions are added.
const EffectKinds& all_kinds();

using EffectList = std::vector<std::unique_ptr<Effect>>;

/// Returns effects as a list for make_model's `made`; null effects are left out.
template <class... E>
EffectList made(std::unique_ptr<E>... effects) {
  EffectList list;
  ((effects ? list.push_back(std::move(effects)) : void()), ...);
  return list;
}

/// Returns the scene's bodies with the effects that have a table in the scene: those of all_kinds() in its order, then
/// those of other kinds. Callers that need access to an effect make it and pass it in `made`. Throws InputError for
/// limits of a run that other effects exceed. Throws InputError for an effect in `made` that is not in the scene or is
/// given twice. Throws InputError for an effect that overrides a function which its kind of scene never calls. Throws
/// the exceptions of check_sharing. Throws InputError for a periodic box that is too short for a neighbour list.
Model make_model(const Scene& scene, EffectList made = {});

/// Makes a model without field solvers, for callers that have field results or need only other effects.
Model make_model_without_field(const Scene& scene);

struct EffectSummary {
  std::string_view name;         ///< name of its table in the scene
  std::string_view description;  ///< one line
  bool in_scene = false;
  Needs needs;                                 ///< needs, if it is in the scene
  std::vector<ExplanationLine> explanation{};  ///< lines of `explain`, if it is in the scene
};

/// Returns a summary of every effect, in the order of make_model.
std::vector<EffectSummary> summarize_effects(const Scene& scene);

}  // namespace lichtenberg::effects
