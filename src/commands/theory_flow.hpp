#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "src/commands/theory_tables.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {

/// What `theory hydrodynamics` follows.
struct FlowRequest {
  double restitution = 0, charge_number = 0;
  double length = 0;          ///< of the box, l_0
  double grains = 0;          ///< whose thermal noise disturbs it
  double end = 0;             ///< t_0 of the start
  bool charges_last = false;  ///< or they fade as the thermal speed does (G 6.29)
  bool separated = false;     ///< charges of either sign, apart from each other (G A5.3), or the same everywhere
  int dimension = 2, cells = 0;
  std::uint64_t seed = 1;
  std::function<void(double own, double end)> at = {};  ///< told how far it is, in the gas's own time
};

/// Its course, with pictures of it, and the last fields of the plane or of space. Throws InputError outside of its
/// range.
TheoryAnswer flow_theory(const FlowRequest& request, Lattice& last);

}  // namespace lichtenberg
