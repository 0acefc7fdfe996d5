#pragma once

#include <span>
#include <vector>

#include "src/effects/groups.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A conductance between two nodes of ElectricalGroups, or between a node and a potential source. Its current from a to
/// the other end is conductance * potential difference + source.
struct Resistor {
  int a = 0;               ///< node
  int b = -1;              ///< node; -1: the other end is `supply`
  int supply = -1;         ///< index in potential_sources_of
  double potential = 0;    ///< V, of the potential source
  double conductance = 0;  ///< S
  double source = 0;       ///< A; 0 for ohmic resistors
  bool series = false;     ///< true: a series resistor; false: a contact
  /// True for a contact whose law depends on its state; its current is linearized about a state.
  bool depends_on_state = false;
  friend bool operator==(const Resistor&, const Resistor&) = default;
};

/// Throws InputError for field methods and couplings that do not support resistors. Charge transport at a finite rate
/// is one implicit step together with the field (docs/numerics/coupling.md).
void check_resistors(const Draft& draft);

/// Throws InputError for two effects with a sharing law, for a sharing law of an effect of grains, or for one without
/// effects.contact_discharge, which detects contacts.
void check_sharing(const Scene& scene);

/// Returns true if the scene may have resistors: an electrode behind a resistor, or contacts that do not join their
/// bodies.
bool has_resistors(const Scene& scene);

/// Returns true if the scene has an electric circuit, for which currents and powers are recorded: a potential
/// difference between sources, a leaking fluid, or resistors.
bool has_circuit(const Scene& scene);

/// Returns the series resistors, then the contacts that do not join their bodies. A contact whose law depends on its
/// state has zero conductance until it is linearized.
std::vector<Resistor> resistors_of(const Scene& scene, std::span<const Contact> contacts);

/// Returns the current (A) of a contact whose law depends on its state. Throws InputError unless the law's conductance
/// is finite and at least 0. Throws InputError for a law that reads the gap without a `gap_scale`, or with one that is
/// not greater than 0.
double contact_current(const Scene& scene, Contact contact, const ContactState& state);

/// Linearizes the current of contact_current() about a state. The conductance is its derivative with respect to the
/// potential difference, or 0 if the derivative is negative.
void linearize(const Scene& scene, Contact contact, const ContactState& state, Resistor& resistor);

/// Coefficients of a step dt of dQ/dt = J - Q/tau + I, implicit in the current I of resistors to a node:
///
/// ```
///   Q(t + dt) = decay Q(t) + injection_time J + F,        F = weight I(t + dt) + inherited F_before.
/// ```
///
/// F is the remainder, after leakage, of the charge that came through resistors in the step. F_before is that of the
/// previous step. Leakage and J are exact. I uses the second-order backward differentiation formula for unequal steps,
/// or backward Euler if there is no previous step. The factor exp(-t/tau) is included such that a constant current is
/// exact at any dt/tau. Without leakage, F is the total charge through resistors.
///
/// The step is stable for any conductance, and damping increases with the conductance. A resistor of infinite
/// conductance joins its ends. Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section
/// III.5 (the formula with variable steps; there in the values Q, here in their increments).
struct ChargeStep {
  double decay = 1;           ///< 1
  double injection_time = 0;  ///< s
  double weight = 0;          ///< s
  double inherited = 0;       ///< 1
  /// Weight (s) and inherited factor (1) for the total charge through a resistor in the step, including the leaked
  /// part.
  double total_weight = 0, total_inherited = 0;
};

/// Returns the coefficients of a step. `dt`: length (s) of the step. `relaxation_time`: s, INFINITY without leakage.
/// `before`: length (s) of the previous step, 0 if there is none with a smooth transition of the currents.
ChargeStep charge_step(double dt, double before, double relaxation_time);

/// Estimates the error (C) of a step's charge through a resistor from its currents (A) at the start and the end. The
/// error is the difference between `carried` (C, in a step of dt in s) and the integral of a smooth current between
/// them. This current is linear if the magnitude does not fall. If it falls, it decays exponentially at a rate z/dt,
/// which implicit steps damp to 1/(1 + z), so that fast transients need not be resolved. `noise` (A): part of the first
/// current that may be an error of the field solver.
double charge_error(double carried, double dt, double at_start, double at_end, double noise);

}  // namespace lichtenberg::effects
