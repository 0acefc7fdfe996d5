#pragma once

#include <span>
#include <vector>

#include "src/effects/groups.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A series resistor or resistive contact between two nodes (conductors or circuit_nodes()), or between a node and a
/// potential source. Its current from a to the other end is conductance * (potential difference) + source.
struct Resistor {
  int a = 0;               ///< node
  int b = -1;              ///< node; -1: the other end is the potential source `supply`
  int supply = -1;         ///< index of the potential source in potential_sources_of()
  double potential = 0;    ///< potential of the source (V), at time 0 if it varies
  double conductance = 0;  ///< S
  double source = 0;       ///< constant part of the current (A); 0 for ohmic resistors
  bool series = false;     ///< true: a series resistor; false: a contact
  int partner = -1;        ///< of a contact: Contact::partner, because several terminals can have one node
  /// True for a contact whose conductance depends on its voltage or gap; its current is linearized about a state.
  bool depends_on_state = false;
  friend bool operator==(const Resistor&, const Resistor&) = default;
};

/// Checks a scene with series resistors or resistive contacts, whose charge transport is an implicit step together with
/// the field (docs/numerics/coupling.md). Throws InputError for a field method, coupling, integrator or field.accuracy
/// that resistors do not allow, and the exceptions of check_sharing().
void check_resistors(const Draft& draft);

/// Checks the effects that define a conductance of contacts (EffectKind::sharing). Throws InputError if the scene has
/// two of them or one for grains, or if it lacks effects.contact_discharge, which detects contacts.
void check_sharing(const Scene& scene);

/// Returns true if the scene may have resistors: an electrode or a circuit behind a series resistor, or an effect that
/// defines a conductance of contacts.
bool has_resistors(const Scene& scene);

/// Returns true if the scene has an electric circuit, for which currents and powers are recorded. A circuit needs a
/// field, and a potential difference between sources, a source that varies in time, a conducting fluid, or resistors.
/// Circuits with a source or a capacitance count as well.
bool has_circuit(const Scene& scene);

/// Returns the resistors of a scene with these closed contacts: series resistors of electrodes, then contacts of finite
/// conductance. A contact whose conductance depends on its state has conductance 0 until linearize() sets it.
std::vector<Resistor> resistors_of(const Scene& scene, std::span<const Contact> contacts);

/// Returns the current (A) through a contact whose conductance depends on its state (voltage and gap). Throws
/// InputError unless the conductance is finite and at least 0. Throws InputError if the law reads the gap but has no
/// finite `gap_scale`, and for a `gap_scale` that is not positive.
double contact_current(const Scene& scene, Contact contact, const ContactState& state);

/// Sets conductance and source of a resistor to the linearization of contact_current() about a state. The conductance
/// is the derivative of the current by the potential difference, or 0 if the derivative is negative.
void linearize(const Scene& scene, Contact contact, const ContactState& state, Resistor& resistor);

/// Coefficients of a time step dt for the charge Q of a node: dQ/dt = J - Q/tau + I. J is the injected current and tau
/// the charge relaxation time of leakage. I is the current of resistors into the node, in which the step is implicit:
///
/// ```
///   Q(t + dt) = decay Q(t) + injection_time J + F,        F = weight I(t + dt) + inherited F_before.
/// ```
///
/// F is the charge that came through resistors in the step and has not leaked. F_before is F of the previous step.
/// Leakage and J are exact. I uses the second-order backward differentiation formula (BDF2) for unequal steps, or
/// backward Euler if there is no previous step. The factor exp(-t/tau) is included such that a constant current is
/// exact at any dt/tau. Without leakage, F is the total charge through resistors.
///
/// Steps of constant length are stable for any conductance. In the limit of infinite conductance both ends of a
/// resistor have the same potential. Source: Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I,
/// section III.5. It states the formula for the values Q; here it is for their increments.
struct ChargeStep {
  double decay = 1;           ///< 1
  double injection_time = 0;  ///< s
  double weight = 0;          ///< s
  double inherited = 0;       ///< 1
  /// Factors `weight` (s) and `inherited` (1) of the formula for the total charge through a resistor in the step,
  /// including the leaked part.
  double total_weight = 0, total_inherited = 0;
};

/// Returns the coefficients of an implicit time step for the charge of a node. `dt`: length of the step (s).
/// `relaxation_time`: charge relaxation time (s), INFINITY without leakage. `before`: length (s) of the previous step;
/// 0 if there is none, or if the currents have jumped since.
ChargeStep charge_step(double dt, double before, double relaxation_time);

/// Returns an estimate of the error (C) of the charge that a resistor carries in an implicit step of length dt (s). It
/// is the difference between `carried` (C) and the integral of a smooth current from `at_start` to `at_end` (A). This
/// current is linear if its magnitude does not fall or its sign changes. Otherwise it decays exponentially at a rate
/// z/dt, which an implicit step damps to 1/(1 + z), so that fast transients need not be resolved. `noise` (A): bound on
/// the error of `at_start` due to the field solver.
double charge_error(double carried, double dt, double at_start, double at_end, double noise);

}  // namespace lichtenberg::effects
