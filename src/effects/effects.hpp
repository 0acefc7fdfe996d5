#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// The scene's bodies with the effects whose tables stand in the scene, and no other. `solver` is used for the field
/// if the scene has one; null: the solver that the scene asks for, at the tolerance of a moving scene.
Model make_model(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver = nullptr);

struct EffectSummary {
  std::string_view name;         ///< of its table in the scene
  std::string_view description;  ///< one line
  bool in_scene = false;
  Needs needs;  ///< of one that is in the scene
};

/// Every effect that there is, in the order in which make_model takes them.
std::vector<EffectSummary> summarize_effects(const Scene& scene);

}  // namespace lichtenberg::effects
