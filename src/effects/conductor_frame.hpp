#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {

/// State of a fixed-potential body (an electrode, an electrode side of the domain, or a wire at a prescribed potential)
/// and its cumulative charge.
struct TerminalReading {
  std::string name;
  double potential = 0;  ///< V
  double drained = 0;    ///< C, collected from the conductors since the start
  // In a scene with a circuit:
  double series_resistance = 0;  ///< ohm
  double surface_potential = 0;  ///< V, behind the series resistor; equal to `potential` without one
  /// C, delivered by the source since the start, including charge on the electrode itself
  double delivered = 0;
};

/// Sources and sinks of a circuit's energy since the start (J).
struct EnergyFlows {
  double by_supplies = 0, by_source = 0;                                         ///< delivered
  double series_resistors = 0, contacts = 0, leakage = 0, sparks = 0, drag = 0;  ///< converted to heat

  double supplied() const { return by_supplies + by_source; }
  double dissipated() const { return series_resistors + contacts + leakage + sparks + drag; }
};

/// Energy of a scene with a circuit, except for that of the field.
struct EnergyBalance {
  double kinetic = 0, elastic = 0;  ///< J, current values
  EnergyFlows flows;
};

/// Means since the previous frame (analysis/circuit.hpp); NaN in the first frame.
struct CircuitRates {
  std::vector<double> current;  ///< A, delivered by each terminal's potential source
  /// ohm, between the terminals of highest and lowest potential
  double structure_resistance = NAN;
  double supplied_power = NAN;      ///< W
  double dissipated_power = NAN;    ///< W
  double entropy_production = NAN;  ///< W/K
};

/// State of a scene of conductors at one instant.
struct ConductorFrame {
  double time = 0;             ///< s
  std::vector<Vec3> position;  ///< m; z is 0 in two dimensions
  std::vector<Vec3> velocity;  ///< m/s
  // Empty without a field:
  std::vector<Vec3> force;        ///< N, electric force
  std::vector<double> charge;     ///< C
  std::vector<double> potential;  ///< V
  /// Smallest index of the conductors in electrical contact; -1: connected to an electrode
  std::vector<int> group;
  double energy = 0;          ///< J, energy of the field
  double charge_held = 0;     ///< C, stored on the conductors
  double charge_fed = 0;      ///< C, injected by the source since the start
  double charge_drained = 0;  ///< C, collected by the electrodes since the start: the sum over terminals
  std::vector<TerminalReading> terminals;
  double charge_leaked = 0;                     ///< C, leaked into the fluid since the start
  std::optional<EnergyBalance> energy_balance;  ///< only for a scene with a circuit
  std::optional<CircuitRates> rates;            ///< as energy_balance, from the second frame on
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;  ///< linear-solver iterations of all solves
};

/// Returns the columns of a frame. With a circuit they include cumulative quantities and means since the previous
/// frame, NaN without rates.
Frame columns_of(const ConductorFrame& frame);

/// Reads a frame from its columns, except for potentials and resistances of the terminals and the rates. Throws
/// InputError if a required column is missing while related ones exist.
ConductorFrame conductor_frame(const Frame& frame);

}  // namespace lichtenberg
