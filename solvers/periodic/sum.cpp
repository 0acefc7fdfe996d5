#include "solvers/periodic/sum.hpp"

#include <algorithm>

namespace lichtenberg::periodic {

void Sum::forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                 std::vector<double>& force) {
  Response response;
  evaluate(sources, pairs, team, response);
  force = std::move(response.force);
}

void Sum::dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                       std::span<double> field) {
  const std::vector<double> none(sources.size());
  Response response;
  evaluate({sources.lengths, sources.position, none, sources.dipole}, pairs, team, response);
  std::ranges::copy(response.field, field.begin());
}

}  // namespace lichtenberg::periodic
