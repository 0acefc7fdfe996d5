#pragma once

#include <optional>
#include <vector>

#include "src/effects/charges.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/extrapolated_field.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/mechanics/energy_budget.hpp"

namespace lichtenberg::mechanics {

/// Resistors (series resistors of electrodes, and contacts of finite conductance), and the charge that they carried in
/// the last step.
struct CarriedCharges {
  std::vector<effects::Resistor> resistors;
  /// By resistor (effects::charge_step): current at the end of the step (A), charge carried in it that has not leaked,
  /// and all charge carried in it (C).
  std::vector<double> current, remaining, total;
  double noise = 1;      ///< 1: currents follow from potentials, with the solver's error; 0: from a step
  double last_step = 0;  ///< s, length of the last step; 0: the currents jump before the next
};

/// Electrical state of a scene of conductors that changes in time: contacts, equipotential groups, charges, currents
/// and field. Assigning a copy restores the state.
struct ElectricalState {
  double time = 0;  ///< s, to which charges are advanced
  /// s; at this time sources have their potentials after a jump, at others those before it
  double corner = 0;
  std::vector<effects::Contact> contacts;  ///< in ascending order
  effects::ElectricalGroups groups;
  effects::Charges charges;
  CarriedCharges carried;
  /// C, by terminal: charge that came from conductors through contacts of finite conductance since the start; empty
  /// without circuits
  std::vector<double> received;
  effects::Electrostatics field;                ///< of the last accepted solve; without potentials before the first
  effects::ExtrapolatedField extrapolated;      ///< extrapolated field that acts on the bodies
  std::optional<EnergyBudget> energy;           ///< empty in a scene without a circuit
  std::vector<double> recorded_positions;       ///< m, positions at the last record of energy
  std::vector<Vec3> recorded_force;             ///< N, forces at that time
  double largest_force = 0, largest_speed = 0;  ///< N, m/s, of any body at any accepted instant
};

/// Field solve at an instant that is not yet accepted, and the step of charges up to it. It changes no state until
/// Electrics::accept() commits it.
struct Trial {
  double time = 0;  ///< s
  effects::Electrostatics field;
  effects::ChargeStep step;  ///< from ElectricalState::time to `time`
  /// A, current of the effects into each conductor; with current sources also the mean current of the step into each
  /// circuit node
  std::vector<double> injected_current{};
};

}  // namespace lichtenberg::mechanics
