#include "src/effects/effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "solvers/error.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/contact_resistance.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/gravity.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::effects {

EffectKinds conductor_kinds() {
  return {
      &FloatingConductorsOptions::kind(), &CurrentInjectionOptions::kind(),
      &StokesDragOptions::kind(),         &GravityOptions::kind(),
      &HertzContactOptions::kind(),       &WallContactOptions::kind(),
      &ContactDischargeOptions::kind(),   &LeakageOptions::kind(),
      &ContactResistanceOptions::kind(),
  };
}

namespace {

/// Returns the descriptions of the scene's effects, in the order of make_model().
EffectKinds kinds_in(const Scene& scene) {
  Effects effects = scene.effects;
  effects.sort(all_kinds());
  EffectKinds kinds;
  for (const Effects::Entry& entry : effects) kinds.push_back(entry.kind);
  return kinds;
}

/// Removes the effect described by `kind` from the list and returns it; null if it is missing.
std::unique_ptr<Effect> take(EffectList& list, const EffectKind& kind) {
  const auto found = std::ranges::find_if(list, [&](const auto& effect) { return effect->name() == kind.name; });
  if (found == list.end()) return nullptr;
  std::unique_ptr<Effect> effect = std::move(*found);
  list.erase(found);
  return effect;
}

struct OverriddenFunction {
  const char* name;
  bool Overrides::*overridden;
};

[[noreturn]] void refuse_function(const Scene& scene, const EffectKind& kind, const std::string& what) {
  throw InputError(fmt::format("{}: effects.{} cannot act: its class overrides {}", scene.path, kind.name, what));
}

/// Throws InputError for an effect that overrides a function which is never called for the bodies of the scene
/// (conductors or grains). The contribution of the function would be missing from the result.
void check_functions(const Scene& scene, const EffectKind& kind) {
  using O = Overrides;
  static constexpr OverriddenFunction conductor_functions[] = {{"drag", &O::drag},
                                                               {"add_currents", &O::add_currents},
                                                               {"charge_relaxation_time", &O::charge_relaxation_time},
                                                               {"accept", &O::accept}};
  static constexpr OverriddenFunction grain_functions[] = {{"grain_contact", &O::grain_contact},
                                                           {"exchange_charges", &O::exchange_charges},
                                                           {"drive", &O::drive},
                                                           {"set_surface", &O::set_surface}};
  const Overrides& own = kind.make.overrides();
  if (!kind.grains) {
    for (const OverriddenFunction& one : grain_functions)
      if (own.*one.overridden)
        refuse_function(scene, kind, fmt::format("{}, which is called for grains alone", one.name));
    return;
  }
  for (const OverriddenFunction& one : conductor_functions)
    if (own.*one.overridden)
      refuse_function(scene, kind,
                      fmt::format("{}, which is never called for grains: add_forces with stored_energy, "
                                  "drive, exchange_charges and grain_contact are",
                                  one.name));
  if (own.add_forces && !own.stored_energy)
    refuse_function(scene, kind,
                    "add_forces but not stored_energy: the energy of grains counts the potential of their "
                    "forces; drive is for forces without a potential");
  if (own.stored_energy && !own.add_forces)
    refuse_function(scene, kind, "stored_energy but not add_forces, the slope of that energy");
}

/// Builds the neighbour list once, so that a periodic box that is too short for it is refused at the start.
void search_first(const Scene& scene, Model& model) {
  if (!model.neighbours || !scene.domain.box().any_periodic()) return;
  try {
    update(*model.neighbours, model.bodies);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {} (found at the first search for neighbours)", scene.path, error.what()));
  }
}

}  // namespace

Model make_model(const Scene& scene, EffectList made) {
  EffectList effects;
  check_sharing(scene);
  for (const EffectKind* kind : kinds_in(scene)) {
    check_functions(scene, *kind);
    std::unique_ptr<Effect> effect = take(made, *kind);
    if (!effect && kind->check_run) kind->check_run(scene);
    effects.push_back(effect ? std::move(effect) : kind->make(scene));
  }
  if (!made.empty() && scene.effects.has(made.front()->name()))
    throw InputError(fmt::format("{}: the model is given two effects \"{}\", but it can have one", scene.path,
                                 made.front()->name()));
  if (!made.empty())
    throw InputError(fmt::format("{}: the scene has no table [effects.{}], but its model is given that effect",
                                 scene.path, made.front()->name()));
  Model model(make_bodies(scene), std::move(effects), initial_charges(scene));
  search_first(scene, model);
  return model;
}

Model make_model_without_field(const Scene& scene) {
  Scene rest = scene;
  rest.effects = {};
  for (const Effects::Entry& entry : scene.effects)
    if (!entry.kind->field) rest.effects.add(*entry.kind, entry.options);
  return make_model(rest);
}

std::vector<EffectSummary> summarize_effects(const Scene& scene) {
  EffectKinds kinds;
  std::ranges::copy_if(all_kinds(), std::back_inserter(kinds),
                       [&](const EffectKind* kind) { return kind->grains == scene.reference.has_value(); });
  for (const EffectKind* kind : kinds_in(scene))
    if (std::ranges::find(kinds, kind) == kinds.end()) kinds.push_back(kind);
  std::vector<EffectSummary> summaries;
  for (const EffectKind* kind : kinds) {
    EffectSummary summary{kind->name, kind->description, scene.effects.has(kind->name), {}};
    if (summary.in_scene) summary.needs = kind->make(scene)->needs();
    if (summary.in_scene && kind->explain) summary.explanation = kind->explain(scene);
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

}  // namespace lichtenberg::effects
