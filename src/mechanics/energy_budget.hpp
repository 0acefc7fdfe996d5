#pragma once

#include <span>
#include <vector>

#include "src/effects/circuit.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// Energy balance of a scene with an electric circuit: energy supplied by sources and converted to heat, summed from
/// one field solve to the next.
///
/// The electrostatic energy of the field is U = 1/2 sum phi Q over all conductors and terminals (electrodes and sides),
/// with potentials phi and charges Q. If charge dQ moves while bodies rest, U changes by exactly dQ times the mean of
/// phi before and after. This holds because potentials are linear in charges. Charge that is injected, leaks or passes
/// a resistor in a step is therefore recorded at the mean potential of the step. This is exact for steps of any length
/// if bodies rest; their motion adds an error of third order.
class EnergyBudget {
 public:
  /// Makes an empty balance. `relaxation_time`: s, of the charges by leakage; infinite without leakage.
  EnergyBudget(const Scene& scene, double relaxation_time);

  /// Adds the charge of a step of dt (s): `current` (A) is injected into each conductor, and `leaked` (C) has left each
  /// node (a conductor, or an electrode behind a resistor) into the fluid.
  void add_step_charges(std::span<const double> current, double dt, std::span<const double> leaked);

  /// Result of a field solve, as the energy balance needs it. Nodes are conductors, and electrodes behind a resistor.
  /// Terminals are electrodes and electrode sides.
  struct Instant {
    double time = 0;                         ///< s
    double energy = 0;                       ///< J, electrostatic energy of the field
    std::vector<double> potential;           ///< V, by node
    std::vector<double> terminal_charge;     ///< C, by terminal
    std::vector<double> drained;             ///< C, collected by each source since the start
    std::vector<double> supply_potential{};  ///< V, by source; empty: constant, as in the scene
  };
  /// Records the energies of all charges added since the last record, and of the charges `carried` by the resistors in
  /// this time (C, from node a to b of each; may be empty). The first call only stores the instant.
  void record(Instant now, std::span<const effects::Resistor> resistors, std::span<const double> carried);
  /// Records the charges added up to an instant at which equipotential groups have merged. `work` (J) is the work of
  /// the field's forces on the bodies since the last record. The remaining loss of field energy is the heat of sparks.
  /// Charges are recorded at the mean of the last potentials and the potentials just before the merge, which are
  /// extrapolated linearly. The error is of first order only for a merge that follows another jump.
  void record_merger(Instant now, double work);
  /// Sets the rates of potentials to 0 until the next record, after a jump of the field that is no group merge.
  void reset_rates();

  /// Adds heat that drag has produced (J) to the budget.
  void add_drag(double joule) { flows_.drag += joule; }

  /// Returns the energies supplied and converted to heat since the start (J).
  const EnergyFlows& flows() const { return flows_; }
  const std::vector<double>& delivered() const { return delivered_; }  ///< C, by source since the start

  /// Returns the complete state after a record as numbers, for a checkpoint: energies (J), time (s), last potentials
  /// and charges with their rates, and the charges collected and delivered by each source (C).
  std::vector<double> save() const;
  /// Returns the length of save(): 9 + 2 (nodes + terminals + sources), and 1 more with sources that vary in time.
  std::size_t saved_size() const;
  /// Restores a state from save(); `saved` must have saved_size() numbers.
  void restore(std::span<const double> saved);

 private:
  Instant before_merger(const Instant& merged) const;
  double mean_potential_of(int supply, const Instant& now) const;
  void update_rates(const Instant& now);

  double relaxation_time_;  ///< s
  std::vector<effects::PotentialSource> supplies_;
  std::vector<effects::Terminal> terminals_;
  EnergyFlows flows_;
  std::vector<double> delivered_;  ///< C, by source
  void record_charges(const Instant& now, std::span<const double> mean_potential,
                      std::span<const double> terminal_charge);

  Instant last_;                                        ///< last record; without potentials before the first
  std::vector<double> potential_rate_, terminal_rate_;  ///< V/s by node, A by terminal; 0 if unknown
  // Sums since the last record:
  std::vector<double> injected_, leaked_;  ///< C, by node
};

}  // namespace lichtenberg::mechanics
