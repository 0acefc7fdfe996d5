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

/// Scene, model and state that a stepper works on. All of them outlive the stepper.
struct StepperContext {
  const Scene& scene;
  Model& model;
  Electrics* electrics;  ///< null in a neutral scene
  Counters& counters;
  std::function<void()> between_steps;  ///< called between steps of any integrator; its exception ends the run
};

/// Integrator of a scene of conductors: mechanics, field and contacts together.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Called when the field at `time` (s) is accepted, at the start and after each checkpoint.
  virtual void begin(double time) = 0;
  /// Advances the scene from `time` to `end` (s). At both ends contacts are up to date and the field is solved.
  /// Positions may differ from those of the solve by a correction of force errors. This is at most two position
  /// tolerances, but more for a body without neighbours after a jump much larger than those before.
  virtual void advance(double time, double end) = 0;
  /// Saves the state that bodies and electrics do not have.
  virtual void save(Checkpoint&) const {}
  /// Restores the state that save() has written.
  virtual void restore(const Checkpoint&) {}
};

std::unique_ptr<Stepper> make_split(const StepperContext&);
std::unique_ptr<Stepper> make_monolithic(const StepperContext&);
std::unique_ptr<Stepper> make_euler(const StepperContext&);

/// Adds an integrator of conductors before any scene is read; `kind` must outlive all scenes. Throws InputError if its
/// name is taken, or if it lacks moves_conductors.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<Stepper> (*make)(const StepperContext&));

/// Makes the integrator of a scene. Throws InputError for one that does not move conductors.
std::unique_ptr<Stepper> make_stepper(const StepperContext& context);

/// Makes CVODE with the accuracy of the scene. Positions are accurate to relative_tolerance of the smallest radius.
/// Momenta are accurate to the larger of the same fraction of themselves and the momentum that carries a body that far
/// before drag stops it (without drag: in one largest step).
Cvode make_cvode(const Scene& scene, Model& model);

/// Adds the heat of drag to the energy balance after each step of CVODE, if the scene has a circuit. The heat is the
/// integral of force times speed by Simpson's rule; the velocity in the middle follows from the positions and
/// velocities at the ends.
void record_drag(const StepperContext& context, Cvode& cvode);

}  // namespace lichtenberg::mechanics
