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

/// An effect that another effect requires in the scene.
struct NeededEffect {
  std::string name;
  std::string why{};  ///< reason, clause that starts with "which"; may be empty
};

/// A line that `lichtenberg explain` prints about an effect: label and text.
struct ExplanationLine {
  std::string label, text;
};

/// Flags of the virtual functions of Effect that a derived class overrides. The list has the functions that are called
/// only in scenes of grains, or only in scenes of conductors.
struct Overrides {
  bool add_forces = false, stored_energy = false;
  bool drag = false, add_currents = false, charge_relaxation_time = false;
  bool grain_contact = false, exchange_charges = false, drive = false, accept = false;
  bool set_surface = false;
};

/// Determines the functions of Effect that the class E overrides. A function that E inherits has the same pointer type
/// as in Base. A function that cannot be named here, because it is private or overloaded, counts as overridden.
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
  own.set_surface = !requires { requires same_as<decltype(&E::set_surface), decltype(&Base::set_surface)>; };
  own.accept = !requires { requires same_as<decltype(&E::accept), decltype(&Base::accept)>; };
  return own;
}

/// Function that makes an effect of a scene, with flags of the functions that the effect's class overrides.
class EffectMaker {
 public:
  EffectMaker() = default;
  /// Stores the function `make`. It takes a scene that has the effect's table and returns a std::unique_ptr to the
  /// effect's own class.
  template <class Make>
  requires std::is_invocable_v<Make, const Scene&> EffectMaker(Make make) : make_(std::move(make)) {
    using Made = typename std::invoke_result_t<Make, const Scene&>::element_type;
    static_assert(!std::same_as<Made, Effect>, "the return type must name the effect's class: leave `-> ...` out");
    overrides_ = overrides_of<Made>();
  }

  template <class Base = Effect>  // a template, so that files need not include the definition of Effect
  std::unique_ptr<Base> operator()(const Scene& scene) const {
    return make_(scene);
  }
  const Overrides& overrides() const { return overrides_; }

 private:
  std::function<std::unique_ptr<Effect>(const Scene&)> make_;
  Overrides overrides_;
};

/// Limits that an effect sets on the time steps of grains. The strictest limit of all effects applies. Functions may be
/// null.
struct StepLimits {
  /// Relative error allowed in the effect's forces: rms error over rms force.
  double (*force_accuracy)(const Scene&) = nullptr;
  /// Length (d0) over which the effect's forces change. Null: the smallest diameter.
  double (*force_length)(const Scene&) = nullptr;
  /// Attraction of grains in contact. Null: the effect's forces bind no two grains.
  ContactAttraction (*contact_attraction)(const Scene&) = nullptr;
};

/// Cost of an effect for each grain, for estimates of time and memory; `bytes` counts the effect's arrays.
struct CostPerGrain {
  /// Time (s) of the effect's forces on one grain, on one core with AVX-512. Null: the forces are timed.
  double (*seconds)(const Scene&) = nullptr;
  /// Number of evaluations of the forces of charges in a step of grains because of this effect. Null: one.
  double (*evaluations_a_step)(const Scene&) = nullptr;
  double bytes = 0;
};

/// Declaration of a kind of effect, such as a force or a charging mechanism. It has the keys of the effect's table in a
/// scene file, its requirements on the rest of the scene, and its maker. An effect's file defines one kind. A list
/// names the kinds (effects::all_kinds(), or a list of the user's own).
struct EffectKind {
  std::string name;         ///< name of its table: [effects.name]
  std::string description;  ///< one line, for `explain`
  std::string help;         ///< help of its table, for `help scene`
  std::any options{};       ///< options of a table without keys, in a type of the effect's own
  std::vector<Key> keys{};  ///< `target` (below) gives the target of a key's value
  std::vector<NeededEffect> needs{};
  std::string alone{};                ///< reason why it must be the only effect; empty: other effects are allowed
  std::string beside{};               ///< name of the only other effect that is allowed although it is `alone`
  std::vector<int> dimensions = {2};  ///< dimensions of space that it supports
  bool periodic = false;              ///< true if it supports periodic sides of the domain

  // Flags that the effect sets for the scene.
  bool grains = false;   ///< a scene of grains, with [units] and reduced units; other scenes are in SI
  bool packing = false;  ///< a static packing that [minimize] brings to rest; nothing happens in time
  bool field = false;    ///< a scene with Laplace's equation, which is solved as [field] specifies

  /// Compares the effect's keys with each other and with the rest of the file before bodies are placed. Throws
  /// InputError (refuse()). This function and the following ones may be null.
  void (*check)(const Draft&) = nullptr;
  /// Compares the keys again after all defaults are filled in and the conductors are placed. Fills in those defaults of
  /// the effect's keys that depend on them.
  void (*complete)(const Draft&, Scene&) = nullptr;
  /// Checks limits that apply to a run but not to other commands. Throws InputError if a limit is exceeded.
  void (*check_run)(const Scene&) = nullptr;
  EffectMaker make{};
  std::vector<ExplanationLine> (*explain)(const Scene&) = nullptr;
  /// Gap (m) between surfaces below which conductors are in electrical contact.
  double (*contact_gap)(const Scene&) = nullptr;
  /// Law by which the two bodies of a contact share charge. At most one effect of a scene may have it. It requires
  /// contact_discharge, which detects the contacts. Null: a contact joins its two bodies into one conductor, unless
  /// another effect has a law.
  effects::SharingLaw (*sharing)(const Scene&, effects::Contact) = nullptr;
  /// Prefactor K of the energy K q_i q_j / r of two charged grains.
  double (*charge_strength)(const Scene&) = nullptr;
  StepLimits steps{};  ///< limits on steps of grains
  /// Distance (d0) of two grain centres at which their mutual polarization diverges.
  double (*closest_approach)(const Scene&) = nullptr;
  CostPerGrain cost{};
  /// Adds the effect's device computation to the steps of grains on a device. Throws InputError
  /// (effects::refuse_on_device) for features that a device does not compute. Null: the effect is refused on a device.
  void (*device)(const Scene&, effects::DeviceForces&) = nullptr;
  std::string energy_advice{};  ///< remedy if a run's energy does not balance; empty: steps and grid

  /// Throws InputError unless the effect supports this dimension of space. `where` ("scene.toml:3: ", for example)
  /// precedes the message.
  void check_dimension(int dimension, const std::string& where = "") const;
  /// Throws InputError if the effect does not support periodic sides of the domain. `where` precedes the message.
  void check_periodic(const std::string& where = "") const;
};

/// Returns the largest value of a number over the effects of a scene; empty if no effect has the number. `number`:
/// member of EffectKind that computes it, such as &EffectKind::contact_gap.
std::optional<double> number_in(const Scene& scene, double (*EffectKind::*number)(const Scene&));
/// Returns the smallest value of a limit on steps over the effects of a scene; empty if no effect has the limit.
/// `number`: member of StepLimits that computes it.
std::optional<double> least_in(const Scene& scene, double (*StepLimits::*number)(const Scene&));

/// Returns true if smooth grains change their motion and charges in contacts alone: no effect of the scene defines
/// Effect::add_forces, drive, exchange_charges or set_surface.
bool only_contacts_act(const Scene& scene);

/// Returns true if an effect of the scene defines Effect::drive (a force or gas drag on grains). Theories of free
/// cooling do not apply then.
bool is_driven(const Scene& scene);

/// Returns the first effect of the scene that defines Effect::set_surface (friction, adhesion or walls of grains); null
/// without one. Theories of smooth grains do not apply then.
const EffectKind* surface_effect(const Effects& effects);
/// Returns the table or key of the scene because of which contacts are not those of smooth grains of one material, such
/// as "effects.friction"; empty: they are.
std::string surface_key(const Scene& scene);

/// Throws InputError for the effect `name` because it requires `needed`, which the scene lacks: "effects.NAME needs
/// NEEDED: add it, or leave the effect out".
[[noreturn]] void refuse_effect(const Draft& draft, const std::string& name, const std::string& needed);

/// Throws InputError if two kinds of effects have the same name, or options of types with the same name.
void check_names(const EffectKinds& kinds);

template <class Options, class Value>
Options options_of(Value Options::*);  // declared only

/// Returns a pointer to the option `member` of an effect in a draft, where the reader stores a key's value: Key{.target
/// = target<&HertzContactOptions::young>, ...}.
template <auto member>
auto* target(Draft& draft) {
  return &(draft.scene.effects.find<decltype(options_of(member))>()->*member);
}

}  // namespace lichtenberg
