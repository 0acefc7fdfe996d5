#pragma once

#include <memory>

#include "src/granular/gas.hpp"

namespace lichtenberg::granular {

/// Interface of a time integrator of a gas of grains, which advances the gas by one step in each call. Reduced units.
class GasIntegrator {
 public:
  virtual ~GasIntegrator() = default;
  /// Returns the longest step (t0) that is allowed in the current state. `now`: quantities of this state; forces may be
  /// added to it. Throws InputError if the integrator refuses the scene's mechanics.step as too long.
  virtual double longest_step(Gas& gas, Instant& now) const = 0;
  /// Advances the gas by one step to the time `end` (t0), at most longest_step() later. `now`: quantities of the
  /// current state. Returns the quantities at `end` that the next step can reuse. With Want::energy they include the
  /// potential energy if they include smooth forces. Throws Failure if the step cannot be computed.
  virtual Instant step(Gas& gas, Instant now, double end, Want want) = 0;

  // For integrators with a memory of earlier steps.

  /// Discards the memory of earlier steps, after a jump of forces or velocities.
  virtual void reset_history() {}
  /// Saves the memory of earlier steps to a checkpoint.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  /// Restores the memory of earlier steps from a checkpoint.
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
};

std::unique_ptr<GasIntegrator> make_multirate();
std::unique_ptr<GasIntegrator> make_verlet();
std::unique_ptr<GasIntegrator> make_gear();
std::unique_ptr<GasIntegrator> make_gear_as_printed();
std::unique_ptr<GasIntegrator> make_cvode();

/// Registers an additional integrator of grains (an extension), which scenes can then select by its name. It must be
/// called before any scene is read, and `kind` must outlive all scenes. Throws InputError if the name is taken, or if
/// `kind` lacks moves_grains or a positive usual_step.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<GasIntegrator> (*make)());

/// Makes the time integrator that a scene of grains selects. Throws InputError for an integrator that does not move
/// grains.
std::unique_ptr<GasIntegrator> make_integrator(Integrator which);

/// Returns the scene's mechanics.step (t0). Throws InputError unless at least `steps_a_contact` such steps fit into the
/// shortest possible contact, and into 1.5 times the damping time of typical impacts.
double step_that_resolves_contacts(const Gas& gas, const Instant& now, double steps_a_contact);

/// Returns the longest step (t0) during which forces other than contacts may be constant; infinite without an
/// attraction. It is a quarter of the oscillation period of the two lightest grains, bound by the attraction of the
/// largest charges. The period is 2 pi sqrt(m_eff / slope of the elastic force) at the equilibrium overlap. Steps
/// longer than a period excite this oscillation. Shorter steps damp it, but hardly for steps up to a quarter of the
/// period (docs/numerics/contact-integration.md).
double max_outer_step(const Gas& gas);

}  // namespace lichtenberg::granular
