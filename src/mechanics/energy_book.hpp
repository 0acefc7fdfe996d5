#pragma once

#include <span>
#include <vector>

#include "src/effects/circuit.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::mechanics {

/// Where the energy of a scene with a circuit comes from and goes to, from one field solve to the next.
///
/// With potentials phi, charges Q and the field's energy U = 1/2 sum phi Q over all conductors and terminals, charge dQ
/// that moves while bodies rest changes U by exactly the mean of phi before and after, times dQ: potentials are linear
/// in charges. So whatever charge is fed, leaks or passes a resistor in a step is booked at the mean potential of the
/// step, which leaves nothing over at any length of step; what moving bodies add to that is of third order.
class EnergyBook {
 public:
  EnergyBook(const Scene& scene, double relaxation_time);  ///< of charges, s

  /// Records the current into each conductor (A, for dt in s) and the charge leaked from each node (C) of the last step.
  void note(std::span<const double> current, double dt, std::span<const double> leaked);

  /// What a field solve found.
  struct Instant {
    double time = 0;                      ///< s
    double energy = 0;                    ///< J, of the field
    std::vector<double> potential;        ///< V, a node
    std::vector<double> terminal_charge;  ///< C
    std::vector<double> drained;          ///< C, to each supply since the start
  };
  /// Books what was noted, and what resistors have `carried` (C, from a to b; may be empty) since the last time.
  void book(Instant now, std::span<const effects::Resistor> resistors, std::span<const double> carried);
  /// Books what was noted up to an instant at which groups have merged. `work` (J): what the field's forces have done
  /// on the bodies since the last time; what the field has lost beyond that went into sparks. What was fed and leaked
  /// since then is booked at the mean of the last potentials and of those that they would have reached at this instant,
  /// had they gone on as between the last two bookings: what is left of first order is a merger that follows a jump.
  void book_merger(Instant now, double work);
  /// Something else than a merger has jumped: how potentials go on is not known before the next booking.
  void forget_rates();

  void add_drag(double joule) { flows_.drag += joule; }

  const EnergyFlows& flows() const { return flows_; }
  const std::vector<double>& delivered() const { return delivered_; }  ///< C, by each supply since the start

  /// All there is right after a booking: energies (J), time (s), and by node, terminal and supply the last instant's
  /// and their rates.
  std::vector<double> save() const;
  /// How many numbers that are: 9 + 2 (nodes + terminals + supplies).
  std::size_t saved_size() const;
  /// `saved` must have saved_size() numbers; throws nothing.
  void restore(std::span<const double> saved);

 private:
  Instant before_merger(const Instant& merged) const;
  void note_rates(const Instant& now);

  double relaxation_time_;  ///< s
  std::vector<effects::Supply> supplies_;
  std::vector<effects::Terminal> terminals_;
  EnergyFlows flows_;
  std::vector<double> delivered_;  ///< C, by supply
  void book_charges(const Instant& now, std::span<const double> mean_potential,
                    std::span<const double> terminal_charge);

  Instant last_;                                        ///< without potentials: nothing is booked yet
  std::vector<double> potential_rate_, terminal_rate_;  ///< V/s, a node, and A, a terminal; 0 where not known
  // Noted since then:
  std::vector<double> fed_, leaked_;  ///< C, a node
};

}  // namespace lichtenberg::mechanics
