#pragma once

#include <string>

namespace lichtenberg {

/// A number of the run's final summary.
struct Quantity {
  std::string name;
  double value = 0;
  std::string unit;
};

}  // namespace lichtenberg
