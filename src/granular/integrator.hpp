#pragma once

#include <memory>

#include "src/granular/gas.hpp"

namespace lichtenberg::granular {

/// Integrator of a gas: one step at a time.
class GasIntegrator {
 public:
  virtual ~GasIntegrator() = default;
  /// Returns the longest step (t0) from here. May compute the forces of `now`. Throws InputError if the scene's step is
  /// too long.
  virtual double longest_step(Gas& gas, Instant& now) const = 0;
  /// Advances the gas from `now` to the time `end`, at most a longest step away. Returns that instant with the values
  /// that the next step can reuse. With Want::energy it includes the energy of smooth forces if it has these forces.
  /// Throws Failure if the step cannot be computed.
  virtual Instant step(Gas& gas, Instant now, double end, Want want) = 0;

  // For integrators with a memory of earlier steps.

  /// Resets the memory after a jump of forces or velocities.
  virtual void reset_history() {}
  /// Saves the memory of earlier steps to a checkpoint.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  /// Restores the memory of earlier steps.
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
};

std::unique_ptr<GasIntegrator> make_multirate();
std::unique_ptr<GasIntegrator> make_verlet();
std::unique_ptr<GasIntegrator> make_gear();
std::unique_ptr<GasIntegrator> make_gear_as_printed();
std::unique_ptr<GasIntegrator> make_cvode();

/// Adds an integrator of grains before any scene is read; `kind` must outlive all scenes. Throws InputError if its name
/// is taken, or if it lacks moves_grains or usual_step.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<GasIntegrator> (*make)());

/// Makes the integrator of a scene. Throws InputError for one that does not move grains.
std::unique_ptr<GasIntegrator> make_integrator(Integrator which);

/// Returns the scene's mechanics.step. Throws InputError unless the shortest possible contact, and the time scale of
/// its dashpot, take at least `steps_a_contact` such steps.
double step_that_resolves_contacts(const Gas& gas, const Instant& now, double steps_a_contact);

/// Returns the longest step (t0) of constant forces by charges. This is a quarter of the oscillation period of a bound
/// pair with the largest charges, 2 pi sqrt(m_eff / slope of the contact force) at equilibrium. Infinite without an
/// attraction. Steps above a period excite this oscillation. Shorter steps damp it, up to a quarter hardly
/// (docs/numerics/contact-integration.md).
double max_outer_step(const Gas& gas);

}  // namespace lichtenberg::granular
