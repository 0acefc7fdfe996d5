#pragma once

#include <optional>

#include "src/granular/gas.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg::granular {

/// What theory says of a gas while it is the same everywhere and its charges do not act (src/theory/haff.hpp): Haff's
/// law with the true restitution, the charge that collisions bring, and how many collisions there are, in the warm-up
/// too. Collisions last: a grain that is in one does not meet the next, omega / (1 + omega t_c).
class HomogeneousGas {
 public:
  /// Empty where the theory does not hold: in the plane, of grains that are few, that differ, are driven or at rest.
  static std::optional<HomogeneousGas> of(const Gas& gas);

  /// Temperature and charges are from now on those of the gas as it is: a stage has begun.
  void begin(const Gas& gas);
  /// Goes on to this time, when the gas has this temperature, within a stage of it.
  void follow(const Gas& gas, double time, double temperature);

  double temperature() const { return temperature_; }
  /// <q^2>; empty if nothing is known of how charges are exchanged.
  std::optional<double> charge_square() const;
  /// Of all grains since the start, of a gas that is as warm as the run was.
  double collisions() const { return collisions_; }

  void save(Checkpoint& checkpoint) const;
  void restore(const Checkpoint& checkpoint);

 private:
  explicit HomogeneousGas(const Gas& gas);
  theory::Impacts impacts(const Gas& gas) const;
  double frequency(double temperature) const;
  void take_law(const Gas& gas);

  double density_ = 0;
  int grains_ = 0;
  bool has_exchange_ = false;
  double time_ = 0, temperature_ = 0, charge_square_ = 0, collisions_ = 0;
  double frequency_ = 0;  ///< of collisions of a grain, of the gas as it was at time_
  std::optional<theory::ImpactTable> means_;
  double stage_ = -1;  ///< when the stage began of which they are
};

}  // namespace lichtenberg::granular
