#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "src/mechanics/counters.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/mechanics/electrics.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/model.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// The scene, model and books that a stepper works on. All of it outlives the stepper.
struct Workplace {
  const Scene& scene;
  Model& model;
  Electrics* electrics;  ///< null in a neutral scene
  Counters& counters;
  std::function<void()> between_steps;  ///< called between two steps of any integrator; ends the run by an exception
};

/// A way to carry a scene forward in time: mechanics, field and contacts together.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Called once the field of `time` is solved and settled, at the start and after every checkpoint.
  virtual void begin(double time) = 0;
  /// Carries the scene from `time` to `end` (s). Contacts are up to date and the field is solved at both ends, but for
  /// what bodies are moved by afterwards, to make up for what forces were wrong by: two position tolerances at most, or
  /// what a jump much larger than those before has moved a body that can touch nothing.
  virtual void advance(double time, double end) = 0;
  /// State beyond that of the bodies and the electrics.
  virtual void save(Checkpoint&) const {}
  virtual void restore(const Checkpoint&) {}
};

std::unique_ptr<Stepper> make_split(const Workplace&);
std::unique_ptr<Stepper> make_monolithic(const Workplace&);
std::unique_ptr<Stepper> make_euler(const Workplace&);

/// Adds an integrator of conductors, which must outlive all scenes, before any scene is read. Throws InputError if its
/// name is taken or it does not say that it moves conductors.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<Stepper> (*make)(const Workplace&));

/// The one that the scene's [mechanics] asks for. Throws InputError for one that does not move conductors.
std::unique_ptr<Stepper> make_stepper(const Workplace& workplace);

/// CVODE at the accuracy that the scene asks for: positions to relative_tolerance of the smallest radius; momenta to
/// the same fraction of themselves, but no finer than what carries a body that far before drag stops it (without drag:
/// in one largest step).
Cvode make_cvode(const Scene& scene, Model& model);

/// Adds the heat of drag to the energy balance after each step of CVODE, if the scene has a circuit: the integral of
/// force times speed by Simpson's rule, with the velocity in the middle that the positions and velocities at the ends
/// give.
void book_drag(const Workplace& at, Cvode& cvode);

}  // namespace lichtenberg::mechanics
