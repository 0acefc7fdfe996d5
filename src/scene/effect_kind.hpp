#pragma once

#include <any>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/scene/schema.hpp"

namespace lichtenberg {

class Effect;

/// An effect that another cannot do without.
struct NeededEffect {
  std::string name;
  std::string why{};  ///< as in "which says who is in contact"; may be empty
};

/// What `lichtenberg explain` says in a line of an effect's own.
struct Remark {
  std::string label, text;
};

/// All that the program knows of a kind of effect before it makes one: what its table in a scene file may hold, what it
/// asks of the rest of the scene, and how one is made. An effect's file defines one, and a list names it
/// (effects::all_kinds(), or one's own).
struct EffectKind {
  std::string name;         ///< of its table: [effects.name]
  std::string description;  ///< one line, for `explain`
  std::string help;         ///< of its table, for `help scene`
  std::any options{};       ///< as they are where the table stands in the file without keys; of a type of its own
  std::vector<Key> keys{};  ///< `place` (below) says where one goes
  std::vector<NeededEffect> needs{};
  std::string alone{};                ///< why no other effect may stand beside it; empty: others may
  std::vector<int> dimensions = {2};  ///< of the space in which it knows what to do
  bool periodic = false;              ///< whether it knows what to do where a side of the domain is periodic

  // What its presence makes of a scene.
  bool grains = false;   ///< one of grains, with [reference] and reduced units; others are in SI
  bool packing = false;  ///< one that [minimize] brings to rest: nothing happens in time
  bool field = false;    ///< one with Laplace's equation, of which [field] says how it is solved
  bool drives = false;   ///< of grains: one whose gas is not left alone, so that no theory of free cooling holds

  /// Compares its keys with each other and with the rest of the file, before anything is placed. Throws InputError
  /// (refuse()). This and what follows may be null.
  void (*check)(const Draft&) = nullptr;
  /// Compares them again once all defaults are filled in and the conductors placed; fills in the defaults of its own
  /// keys that depend on those.
  void (*complete)(const Draft&, Scene&) = nullptr;
  /// What only a run cannot do, where other commands can. Throws InputError.
  void (*check_run)(const Scene&) = nullptr;
  /// Never null. The table stands in the scene.
  std::unique_ptr<Effect> (*make)(const Scene&) = nullptr;
  std::vector<Remark> (*explain)(const Scene&) = nullptr;
  /// m: conductors with surfaces closer than that are in electrical contact.
  double (*contact_gap)(const Scene&) = nullptr;
  /// K of the energy K q_i q_j / r of two charged grains.
  double (*charge_strength)(const Scene&) = nullptr;
  /// The error that forces of charges may have, rms over rms.
  double (*force_accuracy)(const Scene&) = nullptr;
  /// How often a step of grains computes the forces of charges; 1 where no effect says it.
  double (*evaluations_a_step)(const Scene&) = nullptr;
  /// d0: two grains whose centres come that close polarize each other without end.
  double (*closest_approach)(const Scene&) = nullptr;

  double seconds = 0;           ///< that its forces on a grain take on one core, measured; for an estimate of the cost
  std::string energy_advice{};  ///< what to change if a run's energy does not balance; empty: steps and grid

  /// Throws InputError if it cannot do that dimension: a sentence, after `where` ("scene.toml:3: ", say).
  void check_dimension(int dimension, const std::string& where = "") const;
  /// Throws InputError if it cannot do with a periodic side: a sentence, after `where`.
  void check_periodic(const std::string& where = "") const;
};

/// What the scene's first effect that says such a number says, &EffectKind::contact_gap for example; empty if none
/// does.
std::optional<double> number_in(const Scene& scene, double (*EffectKind::*number)(const Scene&));

/// Refuses an effect that lacks something: "effects.NAME needs WHAT: add it, or leave the effect out".
[[noreturn]] void refuse_effect(const Draft& draft, const std::string& name, const std::string& needed);

/// Throws InputError if two have one name.
void check_names(const EffectKinds& kinds);

template <class Options, class Value>
Options options_of(Value Options::*);  // declared only

/// Where a key's value goes: Key{.place = place<&HertzContactOptions::young>, ...}.
template <auto member>
auto* place(Draft& draft) {
  return &(draft.scene.effects.find<decltype(options_of(member))>()->*member);
}

}  // namespace lichtenberg
