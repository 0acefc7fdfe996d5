#pragma once

#include <optional>

#include "src/granular/gas.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg::granular {

/// Predictions for a homogeneous gas whose charges exert no forces (src/theory/haff.hpp). They are Haff's law with the
/// restitution of each impact speed, the mean square charge, and the number of collisions, equilibration included.
/// Collisions have a duration t_c, which reduces their frequency to omega / (1 + omega t_c).
class HomogeneousGas {
 public:
  /// Empty where the theory does not apply: in two dimensions, and for few, unequal, driven or resting grains.
  static std::optional<HomogeneousGas> of(const Gas& gas);

  /// Restarts from the present temperature and charges of the gas, at the start of a stage.
  void begin(const Gas& gas);
  /// Advances to `time`, within a stage. `temperature`: the measured one, from which the number of collisions follows.
  void follow(const Gas& gas, double time, double temperature);

  double temperature() const { return temperature_; }
  /// <q^2> (q0^2); empty if there is no theory of the charge exchange.
  std::optional<double> charge_square() const;
  /// Number of collisions of all grains since the start, at the measured temperatures.
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
  double frequency_ = 0;  ///< collision frequency of a grain at time_ (1/t0)
  std::optional<theory::ImpactTable> means_;
  double stage_ = -1;  ///< t0, start of the stage for which means_ holds
};

}  // namespace lichtenberg::granular
