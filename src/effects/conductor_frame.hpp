#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {

/// What holds conductors at a potential - an electrode, a side of the domain that is one, a wire held from outside -
/// and what has passed through it.
struct TerminalReading {
  std::string name;
  double potential = 0;  ///< V
  double drained = 0;    ///< C, from the conductors to it since the start
  // In a scene with a circuit:
  double series_resistance = 0;  ///< ohm
  double surface_potential = 0;  ///< V, behind the series resistor; without one, the potential
  double delivered = 0;          ///< C, by the supply since the start, what charges the electrode itself included
};

/// Where a circuit's energy came from and went to since the start (J).
struct EnergyFlows {
  double by_supplies = 0, by_source = 0;                                         ///< delivered
  double series_resistors = 0, contacts = 0, leakage = 0, sparks = 0, drag = 0;  ///< turned into heat

  double supplied() const { return by_supplies + by_source; }
  double dissipated() const { return series_resistors + contacts + leakage + sparks + drag; }
};

/// The energy of a circuit's scene, beside that of the field.
struct EnergyBalance {
  double kinetic = 0, elastic = 0;  ///< J, now
  EnergyFlows flows;
};

/// Means since the frame before (analysis/circuit.hpp); NaN in the first frame.
struct CircuitRates {
  std::vector<double> current;        ///< A, delivered by each terminal's supply
  double structure_resistance = NAN;  ///< ohm: of all that is between the terminals of highest and lowest potential
  double supplied_power = NAN;        ///< W
  double dissipated_power = NAN;      ///< W
  double entropy_production = NAN;    ///< W/K
};

/// What a scene of conductors shows of itself at one instant.
struct ConductorFrame {
  double time = 0;             ///< s
  std::vector<Vec3> position;  ///< m; in the plane z is 0
  std::vector<Vec3> velocity;  ///< m/s
  // Of a scene with a field; else empty:
  std::vector<Vec3> force;        ///< N, electric
  std::vector<double> charge;     ///< C
  std::vector<double> potential;  ///< V
  std::vector<int> group;     ///< smallest index of the conductors in electrical contact; -1: connected to an electrode
  double energy = 0;          ///< J, of the field
  double charge_held = 0;     ///< C, on the conductors
  double charge_fed = 0;      ///< C, by the source since the start
  double charge_drained = 0;  ///< C, to the electrodes since the start: the sum over terminals
  std::vector<TerminalReading> terminals;
  double charge_leaked = 0;                     ///< C, into the fluid since the start
  std::optional<EnergyBalance> energy_balance;  ///< of a scene with a circuit
  std::optional<CircuitRates> rates;            ///< the same, once there is a frame before
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;  ///< of the linear solver, all solves together
};

/// The columns that hold it. Those of a scene with a circuit hold what has accumulated and means since the frame
/// before, NaN where there are no rates.
Frame columns_of(const ConductorFrame& frame);

/// What such columns tell: all but potentials and resistances of the terminals and the rates. Throws InputError if a
/// column is missing beside others.
ConductorFrame conductor_frame(const Frame& frame);

}  // namespace lichtenberg
