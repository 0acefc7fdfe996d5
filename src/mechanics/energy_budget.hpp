#pragma once

#include <span>
#include <vector>

#include "src/effects/circuit.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// Energy balance of a scene with a circuit, from one field solve to the next.
///
/// With potentials phi, charges Q and the field's energy U = 1/2 sum phi Q over all conductors and terminals, charge dQ
/// that moves while bodies rest changes U by exactly the mean of phi before and after, times dQ, because potentials are
/// linear in charges. Charge that is injected, leaks or passes a resistor in a step is therefore recorded at the mean
/// potential of the step. This is exact for steps of any length if bodies rest; their motion adds an error of third
/// order.
class EnergyBudget {
 public:
  EnergyBudget(const Scene& scene, double relaxation_time);  ///< s, of charges

  /// Adds the current into each conductor (A, for dt in s) and the charge leaked from each node (C) in the last step.
  void add_step_charges(std::span<const double> current, double dt, std::span<const double> leaked);

  /// Result of a field solve.
  struct Instant {
    double time = 0;                      ///< s
    double energy = 0;                    ///< J, of the field
    std::vector<double> potential;        ///< V, by node
    std::vector<double> terminal_charge;  ///< C, by terminal
    std::vector<double> drained;          ///< C, collected by each source since the start
  };
  /// Records the charges added since the last record and those that resistors have `carried` (C, from a to b; may be
  /// empty).
  void record(Instant now, std::span<const effects::Resistor> resistors, std::span<const double> carried);
  /// Records the charges added up to an instant at which groups have merged. `work` (J) is the work of the field's
  /// forces on the bodies since the last record; the remaining loss of field energy is the heat of sparks. Charges are
  /// recorded at the mean of the last potentials and of potentials extrapolated linearly to just before the merge. The
  /// error is of first order only for a merge that follows another jump.
  void record_merger(Instant now, double work);
  /// Forgets the rates of potentials after a jump that is no group merge, until the next record.
  void reset_rates();

  void add_drag(double joule) { flows_.drag += joule; }

  const EnergyFlows& flows() const { return flows_; }
  const std::vector<double>& delivered() const { return delivered_; }  ///< C, by source since the start

  /// Returns the state right after a record: energies (J), time (s), by node and terminal the last values and their
  /// rates, and by source the charges collected and delivered.
  std::vector<double> save() const;
  /// Length of save(): 9 + 2 (nodes + terminals + sources).
  std::size_t saved_size() const;
  /// Restores a state; `saved` must have saved_size() numbers.
  void restore(std::span<const double> saved);

 private:
  Instant before_merger(const Instant& merged) const;
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
  // Noted since the last record:
  std::vector<double> injected_, leaked_;  ///< C, by node
};

}  // namespace lichtenberg::mechanics
