#include "solvers/periodic/sources.hpp"

#include <fmt/format.h>

#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

void require_consistent(const Sources& sources) {
  const std::size_t n = sources.charge.size();
  const Vec3 lengths = sources.lengths;
  if (!(sources.shortest_length() > 0 && std::isfinite(sources.volume())))
    throw InputError(fmt::format("a periodic box has the lengths {}, {} and {}: all must be positive and finite",
                                 lengths.x, lengths.y, lengths.z));
  if (sources.position.size() != 3 * n || (!sources.dipole.empty() && sources.dipole.size() != 3 * n))
    throw InputError(fmt::format("{} sources have {} coordinates and {} components of dipoles: {} are needed", n,
                                 sources.position.size(), sources.dipole.size(), 3 * n));
}

}  // namespace lichtenberg::periodic
