#include "src/scene/si.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

/// Returns the reduced unit, in SI, of one symbol; empty for a symbol of another quantity.
std::optional<double> reduced_symbol(std::string_view symbol, const Reference& reference) {
  const double d = reference.length, m = reference.mass, v = reference.velocity, q = reference.charge;
  if (symbol == "1") return 1;
  if (symbol == "m" || symbol == "d0") return d;
  if (symbol == "kg" || symbol == "m0") return m;
  if (symbol == "s" || symbol == "t0") return d / v;
  if (symbol == "v0") return v;
  if (symbol == "C" || symbol == "q0") return q;
  if (symbol == "V") return m * v * v / q;
  return {};
}

/// A grain of a scene in SI.
struct SizedGrain {
  double radius = 0;            ///< m
  double relative_density = 1;  ///< of material.density
};

/// Returns the largest grain of a scene in SI.
SizedGrain largest_grain(const Draft& in_si) {
  SizedGrain largest;
  const auto take = [&](double radius, double relative_density) {
    if (radius > largest.radius) largest = {radius, relative_density};
  };
  for (const ConductorDraft& grain : in_si.conductors) take(grain.conductor.radius, grain.conductor.material.density);
  for (const PopulationDraft& population : in_si.populations) {
    if (!population.radius && population.radii.empty())
      refuse(in_si.scene.path, population.line,
             "population.radius is missing: a scene of grains without [units] is in SI and has no default of it");
    if (population.radius) take(population.radius->largest, population.material.density);
    for (const double radius : population.radii) take(radius, population.material.density);
  }
  return largest;
}

}  // namespace

bool is_of_grains_in_si(const toml::table& document, const EffectKinds& kinds) {
  const toml::table* effects = document["effects"].as_table();
  if (!effects || document.contains("units")) return false;
  const auto has = [&](bool grains) {
    return std::ranges::any_of(
        kinds, [&](const EffectKind* kind) { return kind->grains == grains && effects->contains(kind->name); });
  };
  return has(true) && !has(false);
}

void refuse_mixed_effects(const toml::table& document, const EffectKinds& kinds, const std::string& path) {
  const toml::table* effects = document["effects"].as_table();
  if (!effects || document.contains("units")) return;
  const auto first = [&](bool grains) {
    return std::ranges::find_if(
        kinds, [&](const EffectKind* kind) { return kind->grains == grains && effects->contains(kind->name); });
  };
  const auto granular = first(true), other = first(false);
  if (granular == kinds.end() || other == kinds.end()) return;
  const std::string& name = (*other)->name;
  refuse(path, static_cast<int>(effects->get(name)->source().begin.line),
         fmt::format("effects.{} is for scenes of {}, and effects.{} for scenes of grains: leave one of them out{}",
                     name, (*other)->packing ? "packings" : "conductors", (*granular)->name,
                     name == "gravity" ? "; effects.uniform_force gives grains a weight" : ""));
}

std::optional<double> reduced_unit(std::string_view unit, const Reference& reference) {
  double product = 1;
  bool below = false;
  while (!unit.empty()) {
    const std::size_t end = std::min(unit.find_first_of(" /()"), unit.size());
    if (end > 0) {
      const std::string_view factor = unit.substr(0, end);
      const std::size_t power = factor.find('^');
      const auto symbol = reduced_symbol(factor.substr(0, power), reference);
      if (!symbol) return {};
      const int exponent = power == std::string_view::npos ? 1 : factor[power + 1] - '0';
      product *= std::pow(*symbol, below ? -exponent : exponent);
    }
    if (end == unit.size()) break;
    below |= unit[end] == '/';  // units have at most one solidus
    unit.remove_prefix(end + 1);
  }
  return product;
}

std::optional<double> coulombs_of(const toml::node& node) {
  const auto text = node.value<std::string>();
  if (!text || !text->ends_with(" e")) return {};
  double number = 0;
  const char* const end = text->data() + text->size() - 2;
  const auto [stop, error] = std::from_chars(text->data(), end, number);
  if (error != std::errc() || stop != end) return {};
  return number * elementary_charge;
}

double coupling_constant(const Reference& reference) {
  const auto [d0, m0, v0, q0] = reference;
  return q0 * q0 / (4 * std::numbers::pi * vacuum_permittivity * m0 * v0 * v0 * d0);
}

Reference choose_reference(const Draft& in_si, const std::map<std::string, double>& largest) {
  for (const char* key : {"material.density", "stop.time"})
    if (in_si.line(key) == 0)
      refuse(in_si.scene.path, 0,
             fmt::format("{} is missing: a scene of grains without [units] is in SI and has no default of it", key));
  const auto size = [&](const char* unit) { return largest.contains(unit) ? largest.at(unit) : 0.0; };
  const SizedGrain grain = largest_grain(in_si);
  const double d0 = grain.radius > 0 ? 2 * grain.radius : 1;
  const double m0 = in_si.scene.material.density * grain.relative_density * std::numbers::pi / 6 * d0 * d0 * d0;
  const double charge = std::max(size("C"), size("q0"));
  Reference reference{.length = d0, .mass = m0, .velocity = 1, .charge = charge};
  const double by_charges = std::sqrt(coupling_constant(reference));
  const double by_field = std::sqrt(charge * size("m0 v0^2/(q0 d0)") * d0 / m0);
  const double speed = std::max({size("m/s"), size("v0"), std::sqrt(size("m0 v0^2") / m0),
                                 std::sqrt(size("d0/t0^2") * d0), by_charges, by_field});
  if (speed > 0) reference.velocity = speed;
  if (charge == 0)
    reference.charge = std::sqrt(4 * std::numbers::pi * vacuum_permittivity * m0 * d0) * reference.velocity;
  return reference;
}

void require_in_si(const Draft& draft, const std::string& key) {
  if (!draft.scene.in_si || draft.line(key) > 0) return;
  refuse(draft.scene.path, draft.line(key.substr(0, key.rfind('.'))),
         key + " is missing: its default is in reduced units, and a scene of grains without [units] is in SI");
}

}  // namespace lichtenberg
