#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "src/scene/choice.hpp"
#include "src/scene/contact_steps.hpp"

namespace lichtenberg {

struct MechanicsOptions;

/// A way to carry a scene forward in time. Scenes, effects and commands ask for these properties, never for a name. A
/// kind lives as long as the program.
struct IntegratorKind {
  std::string_view name;  ///< value of mechanics.integrator
  bool moves_conductors = false, moves_grains = false;
  std::array<std::string_view, 8> keys{};  ///< of [mechanics] that it reads; the rest empty

  // Of conductors:
  const IntegratorKind* monolithic = nullptr;      ///< takes its place with coupling = "monolithic"; null: itself
  bool solves_field_inside = false;                ///< in its error control, where errors of the field must not show
  bool carries_resistors = true;                   ///< whether resistors can carry charge during its steps
  std::string_view accuracy_key{};                 ///< of [mechanics]: a smaller value gives smaller errors
  double MechanicsOptions::*accuracy = nullptr;    ///< the value of that key
  double MechanicsOptions::*field_step = nullptr;  ///< s, from one field solve to the next, if that is fixed

  // Of grains:
  double usual_step = 0;        ///< t0, the default of mechanics.step
  bool takes_any_step = false;  ///< if effects say how accurate forces are, which then decides on the step
  std::size_t most_grains = 0;  ///< that it can move; 0: any number
  bool is_on_device = false;    ///< whether there is one for a CUDA device

  constexpr bool reads(std::string_view key) const { return std::ranges::find(keys, key) != keys.end(); }
};

/// The integrator that a scene asks for: one of the program's, or of a kind added from outside.
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

/// split: field extrapolated over an error-controlled step; monolithic: field inside the rhs.
enum class FieldCoupling { split, monolithic };
template <>
inline constexpr Named<FieldCoupling> values_named<FieldCoupling>[] = {{FieldCoupling::split, "split"},
                                                                       {FieldCoupling::monolithic, "monolithic"}};

struct MechanicsOptions {
  Integrator integrator = Integrator::cvode;
  FieldCoupling coupling = FieldCoupling::split;
  bool predictor = true;  ///< split: forces between field solves from a coarser grid, if there is one
  double relative_tolerance = 1e-6;
  double position_tolerance = 0;   ///< m: error allowed a coupling step; default 1e-3 radius
  double largest_step = 0;         ///< s: largest coupling step; default output interval
  bool keep_height = false;        ///< in three dimensions nothing moves along z
  double euler_step = 1e-5;        ///< s (D 6.7)
  double euler_field_step = 1e-3;  ///< s (D 6.7)
  // Of grains:
  double step = 0.05;  ///< t0, the longest; of multirate infinite: as long as the accuracy of forces allows
  /// multirate: steps of contacts in the shortest contact that there could be
  int contact_steps = contact_steps_for(usual_contact_accuracy);
  int threads = 0;  ///< of grains; 0: one a core, fewer for few grains

  /// The kind of the integrator, with the coupling taken into account.
  constexpr const IntegratorKind& kind() const {
    return coupling == FieldCoupling::monolithic && integrator->monolithic ? *integrator->monolithic
                                                                           : integrator.kind();
  }
};

/// The program's integrators.
namespace integrators {

inline constexpr IntegratorKind monolithic = {.name = "cvode",
                                              .moves_conductors = true,
                                              .keys = {"coupling", "relative_tolerance", "largest_step", "keep_height"},
                                              .solves_field_inside = true,
                                              .carries_resistors = false,
                                              .accuracy_key = "relative_tolerance",
                                              .accuracy = &MechanicsOptions::relative_tolerance};
inline constexpr IntegratorKind cvode = {.name = "cvode",
                                         .moves_conductors = true,
                                         .moves_grains = true,
                                         .keys = {"coupling", "predictor", "relative_tolerance", "position_tolerance",
                                                  "largest_step", "keep_height", "step", "threads"},
                                         .monolithic = &monolithic,
                                         .accuracy_key = "position_tolerance",
                                         .accuracy = &MechanicsOptions::position_tolerance,
                                         .usual_step = 0.05,
                                         .most_grains = 64};  // the work of its events grows with their square
inline constexpr IntegratorKind euler = {.name = "euler",
                                         .moves_conductors = true,
                                         .keys = {"euler_step", "euler_field_step", "keep_height"},
                                         .accuracy_key = "euler_field_step",
                                         .accuracy = &MechanicsOptions::euler_field_step,
                                         .field_step = &MechanicsOptions::euler_field_step};
inline constexpr IntegratorKind multirate = {.name = "multirate",
                                             .moves_grains = true,
                                             .keys = {"step", "contact_steps", "threads"},
                                             .usual_step = 0.05,
                                             .takes_any_step = true,
                                             .is_on_device = true};
inline constexpr IntegratorKind verlet = {
    .name = "verlet", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.005};
inline constexpr IntegratorKind gear = {
    .name = "gear", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.0015};
inline constexpr IntegratorKind gear_printed = {
    .name = "gear-printed", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.0015};

}  // namespace integrators

inline constexpr Integrator Integrator::cvode{integrators::cvode}, Integrator::euler{integrators::euler},
    Integrator::multirate{integrators::multirate}, Integrator::verlet{integrators::verlet},
    Integrator::gear{integrators::gear}, Integrator::gear_printed{integrators::gear_printed};

/// The integrators that scenes may name: the program's, then those that were added.
struct IntegratorList {
  const Named<Integrator>* begin() const;
  const Named<Integrator>* end() const;
  const Named<Integrator>& operator[](std::size_t k) const { return begin()[k]; }
};
template <>
inline constexpr IntegratorList values_named<Integrator>{};

/// Lets scenes name an integrator. Throws InputError if another has its name. mechanics::add_integrator and
/// granular::add_integrator call it, and say how it is made.
void list_integrator(const IntegratorKind& kind);

/// The names of the integrators that have a property, as in "a", "b" and "c".
std::string names_of(bool IntegratorKind::*property);

}  // namespace lichtenberg
