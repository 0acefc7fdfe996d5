#pragma once

#include <vector>

namespace lichtenberg {

/// Particles as arrays. `dimension` is 2 or 3; position[i * dimension + k] is coordinate k of particle i.
struct Bodies {
  int dimension = 2;
  std::vector<double> position;  ///< m, [N * dimension]
  std::vector<double> momentum;  ///< kg m/s, [N * dimension]
  std::vector<double> mass;      ///< kg, [N]
  std::vector<double> radius;    ///< m, [N]
  std::vector<double> charge;    ///< C, [N]; empty unless an effect needs charges

  int size() const { return static_cast<int>(radius.size()); }
};

}  // namespace lichtenberg
