#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {

/// Potential and cumulative charge of a terminal: an electrode, an electrode side of the domain, or a wire at a
/// prescribed potential.
struct TerminalReading {
  std::string name;
  double potential = 0;  ///< V
  double drained = 0;    ///< charge collected from the conductors since the start (C)
  /// False for an electrode or a side in a circuit, whose source is the circuit's, and for a circuit without a voltage
  /// source
  bool is_source = true;
  // In a scene with a circuit:
  double series_resistance = 0;  ///< ohm
  double surface_potential = 0;  ///< V, behind the series resistor; equal to `potential` without one
  /// Charge that the potential source has delivered since the start (C), including the charge on the electrode itself
  double delivered = 0;
};

/// Energies (J) that a circuit has received from sources and converted to heat since the start.
struct EnergyFlows {
  double by_supplies = 0, by_source = 0;  ///< received from potential sources; from the injected current
  /// Joule heating of series resistors, resistive contacts and the leaking fluid; heat of sparks and of drag.
  double series_resistors = 0, contacts = 0, leakage = 0, sparks = 0, drag = 0;
  /// Sum over the steps of the magnitude of the energy from each potential source, if one varies in time: the energy
  /// goes back and forth. 0 for constant sources
  double turnover = 0;

  double supplied() const { return by_supplies + by_source; }
  double dissipated() const { return series_resistors + contacts + leakage + sparks + drag; }
};

/// Energies (J) of a scene with a circuit, except for the energy of the field.
struct EnergyBalance {
  double kinetic = 0, elastic = 0;  ///< J, at this instant
  EnergyFlows flows;
};

/// Mean currents, powers and resistance of a circuit since the previous frame; NaN in the first frame.
struct CircuitRates {
  std::vector<double> current;  ///< A, delivered by each terminal's potential source
  /// ohm, between the terminals of highest and lowest potential
  double structure_resistance = NAN;
  double supplied_power = NAN;      ///< W
  double dissipated_power = NAN;    ///< W
  double entropy_production = NAN;  ///< W/K
};

/// Recorded state of a scene of conductors at one instant: motion, charges, potentials and energies.
struct ConductorFrame {
  double time = 0;             ///< s
  std::vector<Vec3> position;  ///< m; z is 0 in two dimensions
  std::vector<Vec3> velocity;  ///< m/s
  // Empty without a field:
  std::vector<Vec3> force;        ///< N, electric force
  std::vector<double> charge;     ///< C
  std::vector<double> potential;  ///< V
  /// For each conductor: smallest index of the conductors in electrical contact with it; -1: connected to an electrode
  std::vector<int> group;
  double energy = 0;          ///< J, energy of the field
  double charge_held = 0;     ///< C, stored on the conductors
  double charge_fed = 0;      ///< C, injected into the conductors since the start
  double charge_drained = 0;  ///< C, collected by the electrodes since the start: the sum over terminals
  std::vector<TerminalReading> terminals;
  double charge_leaked = 0;                     ///< C, leaked into the fluid since the start
  std::optional<EnergyBalance> energy_balance;  ///< only for a scene with a circuit
  std::optional<CircuitRates> rates;            ///< as energy_balance, from the second frame on
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;  ///< linear-solver iterations of all solves
};

/// Converts the state of a scene of conductors to a frame of named columns for the result file. With a circuit, the
/// columns include cumulative charges and energies, and means since the previous frame (NaN if there are none).
Frame columns_of(const ConductorFrame& frame);

/// Converts a frame of named columns, made by columns_of(), back to the state of a scene of conductors. The result
/// lacks CircuitRates, and the prescribed potentials and series resistances of terminals. Throws InputError if the
/// frame has potentials of conductors but lacks another column of the field.
ConductorFrame conductor_frame(const Frame& frame);

}  // namespace lichtenberg
