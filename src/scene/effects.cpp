#include "src/scene/effects.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "solvers/error.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {

bool Effects::has(std::string_view name) const {
  return std::ranges::any_of(entries_, [&](const Entry& entry) { return entry.kind->name == name; });
}

bool Effects::has(bool EffectKind::*flag) const {
  return std::ranges::any_of(entries_, [&](const Entry& entry) { return entry.kind->*flag; });
}

std::optional<double> number_in(const Scene& scene, double (*EffectKind::*number)(const Scene&)) {
  std::optional<double> largest;
  for (const Effects::Entry& entry : scene.effects)
    if (const auto of = entry.kind->*number) largest = std::max(of(scene), largest.value_or(-INFINITY));
  return largest;
}

std::optional<double> least_in(const Scene& scene, double (*StepLimits::*number)(const Scene&)) {
  std::optional<double> least;
  for (const Effects::Entry& entry : scene.effects)
    if (const auto of = entry.kind->steps.*number) least = std::min(of(scene), least.value_or(INFINITY));
  return least;
}

bool only_contacts_act(const Scene& scene) {
  return std::ranges::none_of(scene.effects, [](const Effects::Entry& entry) {
    const Overrides& own = entry.kind->make.overrides();
    return own.add_forces || own.drive || own.exchange_charges || own.set_surface;
  });
}

const EffectKind* surface_effect(const Effects& effects) {
  for (const Effects::Entry& entry : effects)
    if (entry.kind->make.overrides().set_surface) return entry.kind;
  return nullptr;
}

std::string surface_key(const Scene& scene) {
  if (const EffectKind* effect = surface_effect(scene.effects)) return "effects." + effect->name;
  for (const Conductor& grain : scene.conductors) {
    if (grain.material.stiffness != 1) return "relative_stiffness";
    if (grain.material.damping != 1) return "relative_damping";
  }
  return "";
}

bool is_driven(const Scene& scene) {
  return std::ranges::any_of(scene.effects,
                             [](const Effects::Entry& entry) { return entry.kind->make.overrides().drive; });
}

namespace {

[[noreturn]] void refuse_namesakes(const std::string& name) {
  throw InputError(fmt::format(
      "two kinds of effects are named \"{}\": their names must differ, because they identify a scene's tables", name));
}

}  // namespace

std::any& Effects::add(const EffectKind& kind, std::any options) {
  const auto found = std::ranges::find(entries_, kind.name, [](const Entry& entry) { return entry.kind->name; });
  if (found != entries_.end() && found->kind != &kind) refuse_namesakes(kind.name);
  Entry& entry = found != entries_.end() ? *found : entries_.emplace_back();
  entry = {&kind, std::move(options)};
  return entry.options;
}

void Effects::remove(std::string_view name) {
  std::erase_if(entries_, [&](const Entry& entry) { return entry.kind->name == name; });
}

void Effects::sort(const EffectKinds& kinds) {
  std::ranges::stable_sort(entries_, {}, [&](const Entry& entry) { return std::ranges::find(kinds, entry.kind); });
}

void EffectKind::check_dimension(int dimension, const std::string& where) const {
  if (std::ranges::find(dimensions, dimension) != dimensions.end()) return;
  throw InputError(where + fmt::format("effects.{} is not allowed in {} dimensions: it supports {}", name, dimension,
                                       fmt::join(dimensions, " and ")));
}

void EffectKind::check_periodic(const std::string& where) const {
  if (!periodic)
    throw InputError(
        where + fmt::format("effects.{} is not allowed with a periodic side: it supports walls and electrodes", name));
}

void refuse_effect(const Draft& draft, const std::string& name, const std::string& needed) {
  refuse(draft.scene.path, draft.line("effects." + name),
         fmt::format("effects.{} needs {}: add it, or leave the effect out", name, needed));
}

void check_names(const EffectKinds& kinds) {
  std::set<std::string> names;
  for (const EffectKind* kind : kinds)
    if (!names.insert(kind->name).second) refuse_namesakes(kind->name);
  // Effects::find distinguishes options by their type, whose name is the same in libraries that are loaded later.
  std::map<std::string, std::string> owner;
  for (const EffectKind* kind : kinds)
    if (const auto [other, is_new] = owner.emplace(kind->options.type().name(), kind->name);
        kind->options.has_value() && !is_new)
      throw InputError(fmt::format("effects.{} and effects.{} have options of types with one name: rename one of them",
                                   other->second, kind->name));
}

}  // namespace lichtenberg
