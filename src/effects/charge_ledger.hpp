#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "solvers/compensated.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/circuit.hpp"

namespace lichtenberg::effects {

/// Who holds how much charge, and what came and went. held + drained + leaked - fed stays what it was at the start, to
/// rounding of the last digit, whatever the field solver's accuracy is: the field only says how a group's charge is
/// shared.
class ChargeLedger {
 public:
  /// `initial`: C, a node of ElectricalGroups. `supplies`: how many there are to drain to (supplies_of).
  ChargeLedger(std::span<const double> initial, std::size_t supplies);

  /// Adds current * dt to each conductor (A, s; D 5.5) and takes away what leaks through the fluid meanwhile
  /// (`relaxation_time`: s).
  void feed(std::span<const double> current, double dt, double relaxation_time = INFINITY);
  /// Takes from the resistor's a, and gives to its b or its supply, the charge (C) that a current from a to b carries:
  /// `plain` all of it, `remaining` what of it has not leaked (charge_step).
  void carry(const Resistor& resistor, double remaining, double plain);
  /// Shares each group's charge as the field does (`by_field`: C, a conductor, D 5.4). A floating group keeps its sum
  /// exactly: what the field's charges miss of it is spread evenly. Held conductors take the field's charges, and the
  /// difference drains to the supply that they are connected with. The team shares the groups.
  void settle(const ElectricalGroups& groups, std::span<const double> by_field,
              parallel::Team& team = parallel::Team::single());

  int size() const { return static_cast<int>(charge_.size()); }
  double charge(int i) const { return charge_[i].total(); }  ///< C
  double held() const;                                       ///< C, all conductors
  double fed() const { return fed_.total(); }                ///< C, since the start
  double leaked() const { return leaked_.total(); }          ///< C, into the fluid since the start
  double drained() const;                                    ///< C, to all supplies since the start
  std::vector<double> drained_by_supply() const;             ///< C, since the start
  /// C, from each node into the fluid, in the last feed and what followed it.
  const std::vector<double>& leaked_in_step() const { return leaked_in_step_; }

  /// Both parts of every sum (charges, drained by supply, fed, leaked): all there is.
  std::vector<double> save() const;
  /// How many numbers that are.
  std::size_t saved_size() const { return 2 * (charge_.size() + drained_.size() + 2); }
  /// Throws Failure if `saved` is of another number of conductors or supplies.
  void restore(std::span<const double> saved);

 private:
  void leak(int node, double charge);
  void share_out(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team);

  std::vector<CompensatedSum> charge_, drained_;
  CompensatedSum fed_, leaked_;
  // The last feed: what a held conductor leaks meanwhile depends on the charge that the field gives it in the end.
  std::vector<double> before_, leaked_in_step_;  ///< C
  double step_ = 0;                              ///< its length in relaxation times
};

}  // namespace lichtenberg::effects
