#pragma once

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Upper bound of the force (m0 v0^2/d0) with which two grains in contact attract each other: constant + by_charge q^2.
/// The argument q of operator() is the largest charge of a grain.
struct ContactAttraction {
  double constant = 0, by_charge = 0;

  LICHTENBERG_HOST_DEVICE double operator()(double charge) const { return constant + by_charge * charge * charge; }
};

}  // namespace lichtenberg
