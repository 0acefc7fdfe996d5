#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "solvers/compensated.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/circuit.hpp"

namespace lichtenberg::effects {

/// Charges of the nodes, and cumulative injected, collected and leaked charge (`fed`, `drained`, `leaked`). The
/// sum of stored, collected and leaked charge minus the injected charge is constant to rounding of the last digit,
/// whatever the accuracy of the field solver. The field only determines how a group's charge is divided among members.
class ChargeLedger {
 public:
  /// `initial`: C, for each node of ElectricalGroups. `supplies`: number of potential sources that collect charge
  /// (supplies_of).
  ChargeLedger(std::span<const double> initial, std::size_t supplies);

  /// Adds current * dt to each conductor (A, s; D 5.5) and subtracts the charge that leaks through the fluid in this
  /// time (`relaxation_time`: s).
  void feed(std::span<const double> current, double dt, double relaxation_time = INFINITY);
  /// Moves the charge (C) of a current from the resistor's a to its b or its potential source. `plain` is the total
  /// charge, `remaining` the part that has not leaked (charge_step).
  void carry(const Resistor& resistor, double remaining, double plain);
  /// Divides each group's charge as the field does (`by_field`: C, for each conductor, D 5.4). A floating group keeps
  /// its sum exactly: its difference from the field's charges is divided equally. Conductors at a prescribed potential
  /// take the field's charges, and their potential source collects the difference. The team works on the groups in
  /// parallel.
  void settle(const ElectricalGroups& groups, std::span<const double> by_field,
              parallel::Team& team = parallel::Team::single());

  int size() const { return static_cast<int>(charge_.size()); }
  double charge(int i) const { return charge_[i].total(); }  ///< C
  double held() const;                                       ///< C, sum over all conductors
  double fed() const { return fed_.total(); }                ///< C, injected since the start
  double leaked() const { return leaked_.total(); }          ///< C, leaked into the fluid since the start
  double drained() const;                                    ///< C, collected by all potential sources since the start
  std::vector<double> drained_by_supply() const;             ///< C, since the start
  /// Charge (C) that leaked from each node into the fluid in the last feed() and the calls after it.
  const std::vector<double>& leaked_in_step() const { return leaked_in_step_; }

  /// Returns both parts of every sum (charges, collected by source, injected, leaked), which are the complete state.
  std::vector<double> save() const;
  /// Returns the number of elements of save().
  std::size_t saved_size() const { return 2 * (charge_.size() + drained_.size() + 2); }
  /// Restores a saved state. Throws Failure if `saved` has another number of conductors or sources.
  void restore(std::span<const double> saved);

 private:
  void leak(int node, double charge);
  void share_out(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team);

  std::vector<CompensatedSum> charge_, drained_;
  CompensatedSum fed_, leaked_;
  // Data of the last feed(). The leakage of a conductor at a prescribed potential depends on its final charge from the
  // field.
  std::vector<double> before_, leaked_in_step_;  ///< C
  double step_ = 0;                              ///< length of the last feed() in relaxation times
};

}  // namespace lichtenberg::effects
