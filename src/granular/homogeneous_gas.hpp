#pragma once

#include <optional>

#include "src/granular/gas.hpp"
#include "src/theory/haff.hpp"

namespace lichtenberg::granular {

/// Theoretical predictions for a homogeneous gas whose charges exert no forces (src/theory/haff.hpp). The temperature
/// follows Haff's law with the restitution of each impact speed; the mean square charge and the number of collisions
/// are predicted, too. Collisions have a duration t_c, which reduces their frequency omega to omega / (1 + omega t_c).
class HomogeneousGas {
 public:
  /// Makes predictions for a gas, from its current state on. Empty where the theory does not apply: in two dimensions,
  /// for fewer than 100 grains, with external drives, and if all grains are at rest. It is also empty unless all grains
  /// have mass m0 and diameter d0.
  static std::optional<HomogeneousGas> of(const Gas& gas);

  /// Restarts the predictions from the current temperature and charges of the gas, at the start of a stage. The number
  /// of collisions is kept.
  void begin(const Gas& gas);
  /// Advances the predictions to `time` (t0) within a stage. `temperature`: measured temperature of the gas at `time`
  /// (m0 v0^2), from which the number of collisions follows.
  void follow(const Gas& gas, double time, double temperature);

  double temperature() const { return temperature_; }
  /// Returns the predicted mean square charge <q^2> (q0^2); empty unless the scene has a charge exchange that the
  /// theory covers.
  std::optional<double> charge_square() const;
  /// Returns the predicted number of collisions of all grains since the start, for the measured temperatures. Stages
  /// are included.
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
