#pragma once

#include <optional>
#include <vector>

#include "src/effects/charges.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/held_field.hpp"
#include "src/mechanics/energy_book.hpp"

namespace lichtenberg::mechanics {

/// Resistors (series resistors and contacts of finite conductance) and the charge that they carried in the last step.
struct CarriedCharges {
  std::vector<effects::Resistor> resistors;
  std::vector<double> current, remaining, plain;  ///< A, C, C, by resistor (charge_step)
  double noise = 1;      ///< 1: currents follow from potentials, with the solver's error; 0: from a step
  double last_step = 0;  ///< s; 0: the currents jump between the last step and the next
};

/// Electrical state of a scene that changes in time, as one value. Assigning a copy restores the state.
struct Charging {
  double time = 0;                         ///< s, to which charges are advanced
  std::vector<effects::Contact> contacts;  ///< in ascending order
  effects::ElectricalGroups groups;
  effects::Charges charges;
  CarriedCharges carried;
  effects::Electrostatics field;                ///< of the last accepted solve; without potentials before the first
  effects::HeldField held;                      ///< extrapolated field that acts on the bodies
  std::optional<EnergyBook> energy;             ///< empty in a scene without a circuit
  std::vector<double> booked_at;                ///< m, positions at the last record of energy
  std::vector<Vec3> booked_force;               ///< N, forces at that time
  double largest_force = 0, largest_speed = 0;  ///< N, m/s, of any body at any accepted instant
};

/// Field at an instant with the charges of that instant. It changes no state until Electrics::accept() commits it.
struct Trial {
  double time = 0;  ///< s
  effects::Electrostatics field;
  effects::ChargeStep step;   ///< from Charging::time to `time`
  std::vector<double> fed{};  ///< A, current of the effects into each conductor
};

}  // namespace lichtenberg::mechanics
