#pragma once

#include <span>
#include <vector>

#include "src/effects/groups.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

/// A conductor between two nodes of ElectricalGroups, or between a node and a supply. Its current from a to the other
/// end is conductance * potential difference + source.
struct Resistor {
  int a = 0;               ///< node
  int b = -1;              ///< node; -1: the other end is `supply`
  int supply = -1;         ///< of supplies_of
  double potential = 0;    ///< V, of the supply
  double conductance = 0;  ///< S
  double source = 0;       ///< A; 0 of ohmic ones
  bool series = false;     ///< a series resistor; if not, a contact
  bool of_state = false;   ///< a contact whose law depends on its state: the current is linearized about one
  friend bool operator==(const Resistor&, const Resistor&) = default;
};

/// What carries charge at a finite rate is one implicit step with the field (README.md), which not every method and no
/// other coupling can do. Throws InputError.
void check_resistors(const Draft& draft);

/// Throws InputError for two effects with a law of sharing, or one in a scene where nothing says who is in contact.
void check_sharing(const Scene& scene);

/// Whether the scene may have resistors: an electrode behind a resistor, contacts that do not join their two.
bool has_resistors(const Scene& scene);

/// Whether a scene has an electric circuit, whose currents and powers are worth booking: a potential difference between
/// supplies, a fluid that leaks, resistors.
bool has_circuit(const Scene& scene);

/// The series resistors, then the contacts that do not join their two. One whose law depends on its state conducts
/// nothing until it is linearized.
std::vector<Resistor> resistors_of(const Scene& scene, std::span<const Contact> contacts);

/// The current (A) of a contact whose law depends on its state. Throws InputError unless the law's conductance is at
/// least 0 and finite.
double contact_current(const Scene& scene, Contact contact, const ContactState& state);

/// Linearizes that current about a state: conductance is its derivative with respect to the potential difference, or 0
/// where that is negative.
void linearize(const Scene& scene, Contact contact, const ContactState& state, Resistor& resistor);

/// A step dt of dQ/dt = J - Q/tau + I, implicit in the current I that resistors carry to a node:
///
///   Q(t + dt) = decay Q(t) + fed J + F,        F = weight I(t + dt) + inherited F_before,
///
/// where F is what is left of the charge that came through resistors in the step, F_before that of the step before.
/// Leakage and J are exact. For I it is the backward differentiation formula of second order for unequal steps, or
/// backward Euler if there is no step before, carried through exp(-t/tau) such that a constant current is exact at any
/// dt/tau; without leakage F is all that came. Stable for any conductance and damping the faster the larger it is: a
/// resistor of infinite conductance makes its ends one. Source: Hairer, Norsett and Wanner, Solving Ordinary
/// Differential Equations I, section III.5 (the formula with variable steps, there in the values Q; here in their
/// increments).
struct ChargeStep {
  double decay = 1;      ///< 1
  double fed = 0;        ///< s
  double weight = 0;     ///< s
  double inherited = 0;  ///< 1
  /// Weight (s) and inherited (1) of what came through a resistor in the step, whether it is still there or has leaked.
  double plain_weight = 0, plain_inherited = 0;
};

/// `dt`: length (s) of the step. `relaxation_time`: s, INFINITY without leakage. `before`: length (s) of the step
/// before, 0 if there is none whose currents lead smoothly to this one's.
ChargeStep charge_step(double dt, double before, double relaxation_time);

/// The error (C) of a step's charge through a resistor, from its currents (A) at the start and the end: how far
/// `carried` (C, in a step of dt in s) is from the integral of a current that goes smoothly from one to the other, on
/// the straight line if they differ little. If it falls much, it decays at a rate z/dt that implicit steps damp to 1/(1
/// + z), and the integral is that of the exponential: what is over soon need not be followed. `noise` (A): how much of
/// the first current may be the field solver's error.
double charge_error(double carried, double dt, double at_start, double at_end, double noise);

}  // namespace lichtenberg::effects
