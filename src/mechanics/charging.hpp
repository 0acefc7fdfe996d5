#pragma once

#include <optional>
#include <vector>

#include "src/effects/charges.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/held_field.hpp"
#include "src/mechanics/energy_book.hpp"

namespace lichtenberg::mechanics {

/// What carries charge at a finite rate, and what it carried in the last step.
struct CarriedCharges {
  std::vector<effects::Resistor> resistors;
  std::vector<double> current, remaining, plain;  ///< A, C, C, by resistor (charge_step)
  double noise = 1;      ///< 1: currents are from potentials, with the solver's error; 0: from a step
  double last_step = 0;  ///< s; 0: none whose currents lead smoothly to the next
};

/// All of the electric half of a scene that goes on in time, as one value. Who keeps a copy can go back to it, whatever
/// has happened since.
struct Charging {
  double time = 0;                         ///< s, until which charges are booked
  std::vector<effects::Contact> contacts;  ///< in ascending order
  effects::ElectricalGroups groups;
  effects::Charges charges;
  CarriedCharges carried;
  effects::Electrostatics field;     ///< of the last solve that was accepted; without potentials before the first
  effects::HeldField held;           ///< what acts on the bodies now
  std::optional<EnergyBook> energy;  ///< of a scene with a circuit
  std::vector<double> booked_at;     ///< positions when energy was last booked
  std::vector<Vec3> booked_force;
  double largest_force = 0, largest_speed = 0;  ///< N, m/s, of a body at any instant that was accepted
};

/// The field at an instant, with the charges of then. Nothing knows of it until it is accepted; dropping it takes it
/// back.
struct Trial {
  double time = 0;  ///< s
  effects::Electrostatics field;
  effects::ChargeStep step;   ///< from the last booking
  std::vector<double> fed{};  ///< A, by the effects, into each conductor
};

}  // namespace lichtenberg::mechanics
