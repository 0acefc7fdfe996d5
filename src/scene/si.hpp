#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <toml++/toml.h>

#include "src/scene/draft.hpp"

namespace lichtenberg {

inline constexpr double vacuum_permittivity = 8.8541878128e-12;  // F/m, CODATA 2018
inline constexpr double elementary_charge = 1.602176634e-19;     // C, exact

/// Returns true if a scene file has effects of grains, none of other scenes, and no table [units]: a scene of grains
/// in SI.
bool is_of_grains_in_si(const toml::table& document, const EffectKinds& kinds);

/// Throws InputError for a scene file without [units] that has effects of grains and effects of other scenes.
void refuse_mixed_effects(const toml::table& document, const EffectKinds& kinds, const std::string& path);

/// Returns the reduced unit, in SI, of a key's unit, such as d0 / t0^2 for "m/s^2" and for "d0/t0^2". Empty for a unit
/// with other symbols than those of mechanics and charge.
std::optional<double> reduced_unit(std::string_view unit, const Reference& reference);

/// Reads a number of elementary charges, as in "1000 e", and returns it in C. Empty for another value.
std::optional<double> coulombs_of(const toml::node& node);

/// Returns the coupling constant K = k_e q0^2 / (m0 v0^2 d0) of charges in vacuum.
double coupling_constant(const Reference& reference);

/// Chooses the reduced units of a scene of grains in SI, whose numbers are as written. `largest`: largest magnitude of
/// the numbers in each unit. The scales d0 and m0 are the diameter and the mass of the largest grain. The speed v0 is
/// the largest one that the scene gives, or that its accelerations, temperatures, fields and charges cause over d0; 1
/// m/s without any. The charge q0 is the largest one that it gives, or that with K = 1. Throws InputError for a scene
/// without radii, density or stop.time, which have no default in SI.
Reference choose_reference(const Draft& in_si, const std::map<std::string, double>& largest);

/// Throws InputError if a scene of grains in SI lacks the key, whose default is in reduced units.
void require_in_si(const Draft& draft, const std::string& key);

}  // namespace lichtenberg
