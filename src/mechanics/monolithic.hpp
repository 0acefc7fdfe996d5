#pragma once

#include "src/mechanics/stepper.hpp"

namespace lichtenberg::mechanics {

/// CVODE with everything inside: the field is solved each time forces are asked for, and its derivatives are left out
/// of Newton's iteration. Exact but for CVODE's own error, and dear: the reference for Split. In a scene without a
/// field it is plain CVODE.
class Monolithic : public Stepper {
 public:
  explicit Monolithic(Workplace workplace);
  void begin(double) override {}
  void advance(double time, double end) override;

 private:
  void solve_field(double time);
  double step(double time, double end);

  Workplace at_;
  Cvode cvode_;
};

}  // namespace lichtenberg::mechanics
