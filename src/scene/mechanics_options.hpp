#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "src/scene/choice.hpp"
#include "src/scene/contact_steps.hpp"

namespace lichtenberg {

struct MechanicsOptions;

/// Properties of a time integrator. Scenes, effects and commands test these properties instead of the name. A kind must
/// exist as long as the program runs.
struct IntegratorKind {
  std::string_view name;  ///< value of mechanics.integrator
  bool moves_conductors = false, moves_grains = false;
  std::array<std::string_view, 8> keys{};  ///< keys of [mechanics] that it reads; unused entries are empty

  // Conductors:
  const IntegratorKind* monolithic = nullptr;  ///< replaces this kind with coupling = "monolithic"; null: none
  /// True if field solves are inside its error control, where field errors must be negligible
  bool solves_field_inside = false;
  bool carries_resistors = true;                   ///< true if resistors can carry charge during its steps
  std::string_view accuracy_key{};                 ///< key of [mechanics] of which smaller values give smaller errors
  double MechanicsOptions::*accuracy = nullptr;    ///< value of that key
  double MechanicsOptions::*field_step = nullptr;  ///< s, interval between field solves, if it is fixed

  // Grains:
  double usual_step = 0;        ///< t0, default of mechanics.step
  bool takes_any_step = false;  ///< true if the force accuracy of effects, or a list of pairs, can set the step
  std::size_t most_grains = 0;  ///< largest number of grains that it can move; 0: no limit
  bool is_on_device = false;    ///< true if it has a CUDA implementation
  /// True if it computes friction, adhesion and walls (Effect::set_surface)
  bool has_surface_forces = false;

  /// Returns true if the integrator reads this key of [mechanics].
  constexpr bool reads(std::string_view key) const { return std::ranges::find(keys, key) != keys.end(); }
};

/// Time integrator that a scene selects: a built-in one, or one of a kind added by list_integrator().
class Integrator {
 public:
  constexpr Integrator(const IntegratorKind& kind) : kind_(&kind) {}

  constexpr const IntegratorKind& kind() const { return *kind_; }
  constexpr const IntegratorKind* operator->() const { return kind_; }
  constexpr bool operator==(const Integrator&) const = default;

  static const Integrator cvode, euler, multirate, verlet, gear, gear_printed;

 private:
  const IntegratorKind* kind_;
};

inline std::string name_of(Integrator integrator) { return std::string(integrator->name); }

/// Coupling of field and motion. split: the field is extrapolated over an error-controlled step. monolithic: the field
/// is solved in each evaluation of the right-hand side.
enum class FieldCoupling { split, monolithic };
template <>
inline constexpr Named<FieldCoupling> values_named<FieldCoupling>[] = {{FieldCoupling::split, "split"},
                                                                       {FieldCoupling::monolithic, "monolithic"}};

/// Options of [mechanics]: integrator, tolerances and steps.
struct MechanicsOptions {
  Integrator integrator = Integrator::cvode;
  FieldCoupling coupling = FieldCoupling::split;
  bool predictor = true;  ///< split: forces between field solves come from a coarser grid, if there is one
  double relative_tolerance = 1e-6;
  /// Error (m) of positions allowed in a coupling step; default 1e-3 of the smallest radius
  double position_tolerance = 0;
  double largest_step = 0;         ///< s, largest coupling step; default: output interval
  bool fix_z = false;              ///< true: in three dimensions nothing moves along z
  double euler_step = 1e-5;        ///< s (D 6.7)
  double euler_field_step = 1e-3;  ///< s (D 6.7)
  // Grains:
  /// Longest step (t0); infinite for multirate: as long as the accuracy of forces allows
  double step = 0.05;
  /// Number of contact substeps in the shortest possible contact, for multirate
  int contact_steps = contact_steps_for(usual_contact_accuracy);
  int threads = 0;  ///< threads for grains; 0: one for each core, fewer for few grains

  /// Returns the properties of the integrator with the coupling taken into account.
  constexpr const IntegratorKind& kind() const {
    return coupling == FieldCoupling::monolithic && integrator->monolithic ? *integrator->monolithic
                                                                           : integrator.kind();
  }
};

/// Built-in integrators.
namespace integrators {

inline constexpr IntegratorKind monolithic = {.name = "cvode",
                                              .moves_conductors = true,
                                              .keys = {"coupling", "relative_tolerance", "largest_step", "fix_z"},
                                              .solves_field_inside = true,
                                              .carries_resistors = false,
                                              .accuracy_key = "relative_tolerance",
                                              .accuracy = &MechanicsOptions::relative_tolerance};
inline constexpr IntegratorKind cvode = {.name = "cvode",
                                         .moves_conductors = true,
                                         .moves_grains = true,
                                         .keys = {"coupling", "predictor", "relative_tolerance", "position_tolerance",
                                                  "largest_step", "fix_z", "step", "threads"},
                                         .monolithic = &monolithic,
                                         .accuracy_key = "position_tolerance",
                                         .accuracy = &MechanicsOptions::position_tolerance,
                                         .usual_step = 0.05,
                                         // The cost of its events grows with the square of this number
                                         .most_grains = 64};
inline constexpr IntegratorKind euler = {.name = "euler",
                                         .moves_conductors = true,
                                         .keys = {"euler_step", "euler_field_step", "fix_z"},
                                         .accuracy_key = "euler_field_step",
                                         .accuracy = &MechanicsOptions::euler_field_step,
                                         .field_step = &MechanicsOptions::euler_field_step};
inline constexpr IntegratorKind multirate = {.name = "multirate",
                                             .moves_grains = true,
                                             .keys = {"step", "contact_substeps", "threads"},
                                             .usual_step = 0.05,
                                             .takes_any_step = true,
                                             .is_on_device = true,
                                             .has_surface_forces = true};
inline constexpr IntegratorKind verlet = {
    .name = "verlet", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.005};
inline constexpr IntegratorKind gear = {
    .name = "gear", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.0015};
inline constexpr IntegratorKind gear_printed = {
    .name = "gear-printed", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.0015};

/// Table of the built-in integrators that scenes may name, in the order of the help text.
inline constexpr std::array all = {&cvode, &euler, &multirate, &verlet, &gear, &gear_printed};

/// Returns true if `makers` (pairs of a kind and the function that makes it) has each built-in kind with the flag
/// `moves`: each that moves conductors, or grains. It compares names, because compilers do not take addresses as
/// constants in builds with sanitizers.
constexpr bool have_all(const auto& makers, bool IntegratorKind::*moves) {
  return std::ranges::all_of(all, [&](const IntegratorKind* kind) {
    return !(kind->*moves) ||
           std::ranges::any_of(makers, [&](const auto& maker) { return maker.first->name == kind->name; });
  });
}

}  // namespace integrators

inline constexpr Integrator Integrator::cvode{integrators::cvode}, Integrator::euler{integrators::euler},
    Integrator::multirate{integrators::multirate}, Integrator::verlet{integrators::verlet},
    Integrator::gear{integrators::gear}, Integrator::gear_printed{integrators::gear_printed};

/// List of the integrators that scenes may name: built-in ones first, then added ones.
struct IntegratorList {
  const Named<Integrator>* begin() const;
  const Named<Integrator>* end() const;
  const Named<Integrator>& operator[](std::size_t k) const { return begin()[k]; }
};
template <>
inline constexpr IntegratorList values_named<Integrator>{};

/// Registers an integrator, so that scenes may name it. Throws InputError if another has its name.
/// mechanics::add_integrator and granular::add_integrator call this function and define how the integrator is made.
void list_integrator(const IntegratorKind& kind);

/// Returns the names of the integrators with this flag for a message, as in "a", "b" and "c".
std::string names_of(bool IntegratorKind::*property);

}  // namespace lichtenberg
