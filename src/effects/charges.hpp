#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "solvers/compensated.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/circuit.hpp"

namespace lichtenberg::effects {

/// Owner of the charges of the nodes (ElectricalGroups) and of the charge injected, collected and leaked since the
/// start. Stored plus collected plus leaked minus injected charge is constant to rounding of the last digit, whatever
/// the accuracy of the field solver. The field only determines how a group's charge is divided among its members.
class Charges {
 public:
  /// Makes the charges at the start. `initial`: C, for each node of ElectricalGroups. `supplies`: number of potential
  /// sources that collect charge (potential_sources_of).
  Charges(std::span<const double> initial, std::size_t supplies);

  /// Adds current * dt to each conductor (A, s; D 5.5) and subtracts the charge that leaks through the fluid in this
  /// time (`relaxation_time`: s).
  void inject(std::span<const double> current, double dt, double relaxation_time = INFINITY);
  /// Moves the charge (C) of a current from the resistor's a to its b or its potential source. `total` is the total
  /// charge, `remaining` the part that has not leaked (charge_step).
  void transfer(const Resistor& resistor, double remaining, double total);
  /// Divides each group's charge as the field does (`by_field`: C, for each conductor, D 5.4). A floating group keeps
  /// its sum exactly: its difference from the field's charges is divided equally. Conductors at a prescribed potential
  /// take the field's charges, and their potential source collects the difference. The team works on the groups in
  /// parallel.
  void distribute(const ElectricalGroups& groups, std::span<const double> by_field,
                  parallel::Team& team = parallel::Team::single());

  /// Returns the charges (C) of the nodes after a step of the given coefficients, before resistors carry any and before
  /// groups divide theirs. `current`: A, injected into each conductor.
  std::vector<double> after(const ChargeStep& step, std::span<const double> current,
                            parallel::Team& team = parallel::Team::single()) const;

  int size() const { return static_cast<int>(charge_.size()); }
  double charge(int i) const { return charge_[i].total(); }  ///< C
  double stored() const;                                     ///< C, sum over all nodes
  double injected() const { return injected_.total(); }      ///< C, since the start
  double leaked() const { return leaked_.total(); }          ///< C, into the fluid since the start
  double collected() const;                                  ///< C, by all potential sources since the start
  std::vector<double> collected_by_source() const;           ///< C, since the start
  /// Charge (C) that leaked from each node into the fluid in the last inject() and the calls after it.
  const std::vector<double>& leaked_in_step() const { return leaked_in_step_; }

  /// Returns both parts of every sum (charges, collected by source, injected, leaked), which are the complete state.
  std::vector<double> save() const;
  /// Returns the number of elements of save().
  std::size_t saved_size() const { return 2 * (charge_.size() + collected_.size() + 2); }
  /// Restores a saved state. Throws Failure if `saved` has another number of conductors or sources.
  void restore(std::span<const double> saved);

 private:
  void leak(int node, double charge);
  void redistribute(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team);

  std::vector<CompensatedSum> charge_, collected_;
  CompensatedSum injected_, leaked_;
  // Data of the last inject(). The leakage of a conductor at a prescribed potential depends on its final charge from
  // the field.
  std::vector<double> before_, leaked_in_step_;  ///< C
  double step_ = 0;                              ///< length of the last inject() in relaxation times
};

}  // namespace lichtenberg::effects
