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

/// Scene, model and electrical state that an integrator (Stepper) advances. They must outlive the integrator.
struct StepperContext {
  const Scene& scene;
  Model& model;
  Electrics* electrics;  ///< null in a neutral scene
  Counters& counters;
  /// Called between steps of any integrator. Throws Failure if a body has moved too far in the last step
  /// (Model::largest_move). Any exception ends the run.
  std::function<void()> between_steps;
  /// Called once after each step with its end and its length dt (s). Wraps positions into the periodic axes, and passes
  /// the step to the effects (Model::accept).
  std::function<void(double end, double dt)> commit;
};

/// Interface of the integrators of a scene of conductors: mechanics, field and contacts together.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Prepares the integrator at `time` (s): at the start, after each checkpoint and after a restore. If the scene has a
  /// field, the caller has already solved and accepted it at this time.
  virtual void begin(double time) = 0;
  /// Advances bodies, charges and contacts from `time` to `end` (s). At both ends contacts are up to date and the field
  /// is solved. Each step ends with StepperContext::commit. Positions may differ from those of the solve by a
  /// correction of force errors, of at most four position tolerances. A merge of equipotential groups may change a
  /// force more than earlier merges did. The correction is then larger for a body that cannot touch another on its
  /// path.
  virtual void advance(double time, double end) = 0;
  /// Returns true if the integrator limits the displacement of a body in each step (Model::largest_move) itself.
  /// Otherwise StepperContext::between_steps checks it.
  virtual bool limits_moves() const { return false; }
  /// Continues at `time` (s) after a corner of a source, at which the accepted field may have jumped. `force_before`:
  /// N, forces on the bodies just before. Integrators without a memory of forces need nothing.
  virtual void pass_corner(double, const std::vector<Vec3>&) {}
  /// Saves the integrator's own state, such as its next step, which is not in the bodies and the electrical state.
  virtual void save(Checkpoint&) const {}
  /// Restores the state that save() has written.
  virtual void restore(const Checkpoint&) {}
};

/// Makes the default integrator, which splits mechanics and field (Split); without a field, the monolithic one.
std::unique_ptr<Stepper> make_split(const StepperContext&);
/// Makes the reference integrator: CVODE, with a field solve in each evaluation of the forces.
std::unique_ptr<Stepper> make_monolithic(const StepperContext&);
/// Makes the explicit Euler integrator with fixed steps.
std::unique_ptr<Stepper> make_euler(const StepperContext&);

/// Registers an integrator of conductors, so that scenes can name it. Call it before any scene is read. `kind` must
/// outlive all scenes; `make` constructs the integrator. Throws InputError if its name is taken, or if it lacks
/// moves_conductors.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<Stepper> (*make)(const StepperContext&));

/// Makes the integrator that the scene names in [mechanics]. Throws InputError for one that does not move conductors,
/// or that does not support the resistors of the scene.
std::unique_ptr<Stepper> make_stepper(const StepperContext& context);

/// Makes the CVODE integrator with the accuracy of the scene. In a step the error of a position is at most x =
/// relative_tolerance times the smallest radius. The error of a momentum is at most relative_tolerance of itself plus
/// an absolute part. The absolute part is the larger of two momenta: drag stops a body with the first after a distance
/// x; a body with the second moves by x in one largest step.
Cvode make_cvode(const Scene& scene, Model& model);

/// Makes CVODE add the heat of drag and of losses in contacts to the energy balance after each step, if the scene has a
/// circuit and such losses. The heat is the integral of force times speed by Simpson's rule. The position and
/// velocity in the middle of a step follow from those at its ends.
void record_drag(const StepperContext& context, Cvode& cvode);

}  // namespace lichtenberg::mechanics
