#pragma once

#include <memory>

#include "src/granular/gas.hpp"

namespace lichtenberg::granular {

/// A way to carry a gas on by one step.
class GasIntegrator {
 public:
  virtual ~GasIntegrator() = default;
  /// The longest step that it may take from here; finds the forces of `now` if it wants them. Throws InputError if the
  /// scene's is too long.
  virtual double longest_step(Gas& gas, Instant& now) const = 0;
  /// Carries the gas on from `now` to `end`, at most a longest step away, and returns that instant with what the next
  /// step can use; with Want::energy it should have the energy of smooth forces, if it has these forces.
  virtual Instant step(Gas& gas, Instant now, double end, Want want) = 0;

  // What follows is for an integrator that remembers something of earlier steps.

  /// Forgets it: forces or velocities have changed at once.
  virtual void begin_anew() {}
  /// Puts it into a checkpoint, and takes it from there.
  virtual void save(Checkpoint& checkpoint) const { (void)checkpoint; }
  virtual void restore(const Checkpoint& checkpoint) { (void)checkpoint; }
};

std::unique_ptr<GasIntegrator> make_multirate();
std::unique_ptr<GasIntegrator> make_verlet();
std::unique_ptr<GasIntegrator> make_gear();
std::unique_ptr<GasIntegrator> make_gear_as_printed();
std::unique_ptr<GasIntegrator> make_cvode();

/// Adds an integrator of grains, which must outlive all scenes, before any scene is read. Throws InputError if its name
/// is taken, or if it does not say that it moves grains and in what usual steps.
void add_integrator(const IntegratorKind& kind, std::unique_ptr<GasIntegrator> (*make)());

/// The one that a scene asks for. Throws InputError for one of conductors.
std::unique_ptr<GasIntegrator> make_integrator(Integrator which);

/// The scene's mechanics.step. Throws InputError unless the shortest contact that there could be now takes so many, and
/// what its dashpot does as well.
double step_that_resolves_contacts(const Gas& gas, const Instant& now, double steps_a_contact);

/// The longest step for which forces of charges may be held: a quarter of the period in which the two of largest charge
/// swing about where charges and contact balance, 2 pi sqrt(m_eff / slope of the contact's force); infinite if nothing
/// holds them together. Forces that are held for more than a whole period drive that swinging, for less they damp it,
/// up to a quarter hardly (README.md).
double longest_hold(const Gas& gas);

}  // namespace lichtenberg::granular
