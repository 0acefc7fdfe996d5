#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "solvers/compensated.hpp"
#include "solvers/parallel/team.hpp"
#include "src/effects/circuit.hpp"

namespace lichtenberg::effects {

/// Charge balance of conductors: the charge of each node (a conductor, or an electrode behind a series resistor), and
/// the charge injected, collected and leaked since the start. Stored + collected + leaked - injected charge is constant
/// to rounding of the last digit, whatever the accuracy of the field solver. The field only divides the charge of an
/// equipotential group among its members.
class Charges {
 public:
  /// Makes the charges at the start. `initial`: charge of each node (C, [nodes]). `supplies`: number of potential
  /// sources that collect charge (potential_sources_of).
  Charges(std::span<const double> initial, std::size_t supplies);

  /// Adds the injected charge current[i] * dt to each conductor i (`current`: A, `dt`: s). Subtracts the charge that
  /// leaks through a conducting fluid in the time dt, with the charge relaxation time `relaxation_time` (s; infinite:
  /// no leakage).
  void inject(std::span<const double> current, double dt, double relaxation_time = INFINITY);
  /// Moves the charge that a resistor carries in a step from its node a to its node b or to its potential source.
  /// `total`: charge through the resistor (C); `remaining`: part of `total` that has not leaked by the end of the step
  /// (charge_step).
  void transfer(const Resistor& resistor, double remaining, double total);
  /// Divides the charge of each equipotential group among its members according to the field solution `by_field` (C,
  /// charge of each node). A floating group keeps its total charge exactly; an error of the field is divided equally
  /// among its members. Nodes at a prescribed potential take the field's charges, and their potential source collects
  /// the difference.
  void distribute(const ElectricalGroups& groups, std::span<const double> by_field,
                  parallel::Team& team = parallel::Team::single());

  /// Returns the charges of the nodes (C, [nodes]) after a time step with injection and leakage only, before transfer()
  /// and distribute(). `step`: coefficients of the step; `current`: current injected into each conductor (A).
  std::vector<double> after(const ChargeStep& step, std::span<const double> current,
                            parallel::Team& team = parallel::Team::single()) const;

  int size() const { return static_cast<int>(charge_.size()); }
  double charge(int i) const { return charge_[i].total(); }  ///< charge of node i (C)
  double stored() const;                                     ///< sum of the charges of all nodes (C)
  double injected() const { return injected_.total(); }      ///< charge injected since the start (C)
  double leaked() const { return leaked_.total(); }          ///< charge leaked into the fluid since the start (C)
  double collected() const;                         ///< charge that all potential sources collected since the start (C)
  std::vector<double> collected_by_source() const;  ///< charge that each potential source collected since the start (C)
  /// Returns the charge (C, [nodes]) that leaked from each node into the fluid since the beginning of the last
  /// inject().
  const std::vector<double>& leaked_in_step() const { return leaked_in_step_; }

  /// Returns the complete state for a checkpoint: both parts of each compensated sum (charges of the nodes, charges
  /// collected by each source, injected charge, leaked charge).
  std::vector<double> save() const;
  /// Returns the number of elements of save().
  std::size_t saved_size() const { return 2 * (charge_.size() + collected_.size() + 2); }
  /// Restores a state of save(). Throws Failure if `saved` does not have saved_size() elements.
  void restore(std::span<const double> saved);

 private:
  void leak(int node, double charge);
  void redistribute(const ElectricalGroups& groups, std::span<const double> by_field, parallel::Team& team);

  std::vector<CompensatedSum> charge_, collected_;
  CompensatedSum injected_, leaked_;
  // Data of the last inject(). The leakage of a conductor at a prescribed potential depends on its final charge from
  // the field.
  std::vector<double> before_, leaked_in_step_;  ///< C
  double step_ = 0;                              ///< length of the last inject() in relaxation times; 0: distributed
};

}  // namespace lichtenberg::effects
