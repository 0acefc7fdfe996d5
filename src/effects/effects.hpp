#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "src/model/model.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// Every kind of effect that this program knows, in the order in which their shares are added up.
const EffectKinds& all_kinds();

using EffectList = std::vector<std::unique_ptr<Effect>>;

/// Effects for make_model's `made`; null ones are left out.
template <class... E>
EffectList made(std::unique_ptr<E>... effects) {
  EffectList list;
  ((effects ? list.push_back(std::move(effects)) : void()), ...);
  return list;
}

/// The scene's bodies with the effects whose tables stand in the scene, and no other: those of all_kinds() in its
/// order, then those of other kinds. Who must know one of them in particular makes it and hands it over in `made`.
/// Throws InputError for what those that are not handed over cannot do in a run, for an effect in `made` that is
/// not in the scene, and for a periodic box that is too short for the neighbours of a particle.
Model make_model(const Scene& scene, EffectList made = {});

/// The same without what solves a field: for who has the field's results, or asks about the rest.
Model make_model_without_field(const Scene& scene);

struct EffectSummary {
  std::string_view name;         ///< of its table in the scene
  std::string_view description;  ///< one line
  bool in_scene = false;
  Needs needs;                    ///< of one that is in the scene
  std::vector<Remark> remarks{};  ///< the same
};

/// Every effect that there is, in the order in which make_model takes them.
std::vector<EffectSummary> summarize_effects(const Scene& scene);

}  // namespace lichtenberg::effects
