#pragma once

#include <any>
#include <concepts>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "src/scene/contact_attraction.hpp"
#include "src/scene/schema.hpp"
#include "src/scene/sharing_law.hpp"

namespace lichtenberg {

class Effect;
namespace effects {
struct DeviceForces;
}

/// An effect that another cannot do without.
struct NeededEffect {
  std::string name;
  std::string why{};  ///< as in "which says who is in contact"; may be empty
};

/// What `lichtenberg explain` says in a line of an effect's own.
struct Remark {
  std::string label, text;
};

/// Functions of Effect that a class overrides, of those that scenes of grains call and scenes of conductors do not, or
/// the reverse.
struct Overrides {
  bool add_forces = false, stored_energy = false;
  bool drag = false, add_currents = false, charge_relaxation_time = false;
  bool grain_contact = false, exchange_charges = false, drive = false, accept = false;
};

/// The functions that E overrides. An inherited function has the type of Base's. One that cannot be named here, because
/// it is private or overloaded, is E's own.
template <class E, class Base = Effect>
constexpr Overrides overrides_of() {
  using std::same_as;
  Overrides own;
  own.add_forces = !requires { requires same_as<decltype(&E::add_forces), decltype(&Base::add_forces)>; };
  own.stored_energy = !requires { requires same_as<decltype(&E::stored_energy), decltype(&Base::stored_energy)>; };
  own.drag = !requires { requires same_as<decltype(&E::drag), decltype(&Base::drag)>; };
  own.add_currents = !requires { requires same_as<decltype(&E::add_currents), decltype(&Base::add_currents)>; };
  own.charge_relaxation_time = !requires {
    requires same_as<decltype(&E::charge_relaxation_time), decltype(&Base::charge_relaxation_time)>;
  };
  own.grain_contact = !requires { requires same_as<decltype(&E::grain_contact), decltype(&Base::grain_contact)>; };
  own.exchange_charges = !requires {
    requires same_as<decltype(&E::exchange_charges), decltype(&Base::exchange_charges)>;
  };
  own.drive = !requires { requires same_as<decltype(&E::drive), decltype(&Base::drive)>; };
  own.accept = !requires { requires same_as<decltype(&E::accept), decltype(&Base::accept)>; };
  return own;
}

/// Makes an effect, and holds which functions its class overrides.
class EffectMaker {
 public:
  EffectMaker() = default;
  /// `make`: takes a scene that has the effect's table and returns a std::unique_ptr to the effect's own class.
  template <class Make>
  requires std::is_invocable_v<Make, const Scene&> EffectMaker(Make make) : make_(std::move(make)) {
    using Made = typename std::invoke_result_t<Make, const Scene&>::element_type;
    static_assert(!std::same_as<Made, Effect>, "the return type must name the effect's class: leave `-> ...` out");
    overrides_ = overrides_of<Made>();
  }

  template <class Base = Effect>  // a template, for files that do not know Effect's members
  std::unique_ptr<Base> operator()(const Scene& scene) const {
    return make_(scene);
  }
  const Overrides& overrides() const { return overrides_; }

 private:
  std::function<std::unique_ptr<Effect>(const Scene&)> make_;
  Overrides overrides_;
};

/// Limits on steps of grains; the strictest of all effects counts. Functions may be null.
struct StepLimits {
  /// The error that the effect's forces may have, rms over rms.
  double (*force_accuracy)(const Scene&) = nullptr;
  /// d0, over which its forces change; null: over the smallest diameter.
  double (*force_length)(const Scene&) = nullptr;
  /// Null: its forces hold no two grains together.
  ContactAttraction (*contact_attraction)(const Scene&) = nullptr;
};

/// For estimates of cost; bytes are those of its arrays.
struct CostPerGrain {
  /// s that its forces take on one core with AVX-512; null: they are timed.
  double (*seconds)(const Scene&) = nullptr;
  /// How often a step of grains computes the forces of charges because of it; null: once.
  double (*evaluations_a_step)(const Scene&) = nullptr;
  double bytes = 0;
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

  /// Compares its keys with each other and with the rest of the file, before anything is placed. Throws InputError
  /// (refuse()). This and what follows may be null.
  void (*check)(const Draft&) = nullptr;
  /// Compares them again once all defaults are filled in and the conductors placed; fills in the defaults of its own
  /// keys that depend on those.
  void (*complete)(const Draft&, Scene&) = nullptr;
  /// What only a run cannot do, where other commands can. Throws InputError.
  void (*check_run)(const Scene&) = nullptr;
  EffectMaker make{};
  std::vector<Remark> (*explain)(const Scene&) = nullptr;
  /// m: conductors with surfaces closer than that are in electrical contact.
  double (*contact_gap)(const Scene&) = nullptr;
  /// The law by which the two of a contact share charge. One effect of a scene may have it, and needs
  /// contact_discharge, which says who is in contact. Null: contacts make their two one conductor, unless another
  /// effect says otherwise.
  effects::SharingLaw (*sharing)(const Scene&, effects::Contact) = nullptr;
  /// K of the energy K q_i q_j / r of two charged grains.
  double (*charge_strength)(const Scene&) = nullptr;
  StepLimits steps{};  ///< of grains
  /// d0: two grains whose centres come that close polarize each other without end.
  double (*closest_approach)(const Scene&) = nullptr;
  CostPerGrain cost{};
  /// Of grains: tells the steps on a device what this effect does there. Throws InputError (effects::refuse_on_device)
  /// for what a device does not compute of it. Null: a device does not compute the effect, and refuses it.
  void (*device)(const Scene&, effects::DeviceForces&) = nullptr;
  std::string energy_advice{};  ///< what to change if a run's energy does not balance; empty: steps and grid

  /// Throws InputError if it cannot do that dimension: a sentence, after `where` ("scene.toml:3: ", say).
  void check_dimension(int dimension, const std::string& where = "") const;
  /// Throws InputError if it cannot do with a periodic side: a sentence, after `where`.
  void check_periodic(const std::string& where = "") const;
};

/// The largest of the numbers that the scene's effects give, &EffectKind::contact_gap for example; empty if none does.
std::optional<double> number_in(const Scene& scene, double (*EffectKind::*number)(const Scene&));
/// The smallest of the numbers that limit steps.
std::optional<double> least_in(const Scene& scene, double (*StepLimits::*number)(const Scene&));

/// True if an effect of the scene drives its grains, so that no theory of free cooling holds.
bool is_driven(const Scene& scene);

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
