#pragma once

#include <vector>

#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {

/// The dissertation's scheme (D 6.42, whose second line lacks a plus sign): explicit Euler with a fixed step, the field
/// and the contacts looked at once every field step, the force constant in between. No error control; the reference
/// that the other integrators are compared with.
class Euler : public Stepper {
 public:
  explicit Euler(Workplace workplace);
  void begin(double) override {}
  void advance(double time, double end) override;

 private:
  void mechanical_steps(double time, double end);

  Workplace at_;
  std::vector<double> force_;  ///< N
};

}  // namespace lichtenberg::mechanics
