#include "solvers/periodic/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::periodic {

ParticleMesh::ParticleMesh(const Mesh& mesh, const Cloud& cloud)
    : lengths_(mesh.lengths),
      near_(mesh.lengths, cloud),
      mesh_(mesh, cloud),
      tiles_(mesh.lengths, std::max(near_.cutoff(), mesh_.reach())) {}

void ParticleMesh::require_usable(const Sources& sources) const {
  require_consistent(sources);
  if (sources.lengths != lengths_)
    throw InputError(fmt::format("The box is {} x {} x {} long, but the mesh was made for {} x {} x {}.",
                                 sources.lengths.x, sources.lengths.y, sources.lengths.z, lengths_.x, lengths_.y,
                                 lengths_.z));
  if (!sources.dipole.empty()) throw InputError("The particle-mesh sum takes charges only, not dipoles.");
}

namespace {

/// The mean force of the mesh, taken off the field with the least change of it that does.
Vec3 net_force_per_charge2(const Tiles& tiles, FieldAndPotential sum) {
  Vec3 net;
  double charge2 = 0;
  for (int s = 0; s < tiles.size(); ++s) {
    const double charge = tiles.place_and_charge(s)[3];
    for (int k = 0; k < 3; ++k) net[k] += charge * sum[4 * s + k];
    charge2 += charge * charge;
  }
  return charge2 > 0 ? net / charge2 : Vec3{};
}

void fill(const Sources& sources, const Tiles& tiles, FieldAndPotential sum, Response& response) {
  const std::size_t n = sources.size();
  response.potential.resize(n);
  response.field.resize(3 * n);
  response.force.resize(3 * n);
  const Vec3 off = net_force_per_charge2(tiles, sum);
  response.energy = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double charge = sources.charge[i], *of = &sum[4 * tiles.sorted(static_cast<int>(i))];
    for (int k = 0; k < 3; ++k) {
      response.field[3 * i + k] = of[k] - charge * off[k];
      response.force[3 * i + k] = charge * response.field[3 * i + k];
    }
    response.potential[i] = of[3];
    response.energy += 0.5 * charge * of[3];
  }
}

}  // namespace

void ParticleMesh::evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            Response& response) {
  require_usable(sources);
  sum_.resize(4 * sources.charge.size());
  tiles_.sort(sources);
  near_.compute(tiles_, pairs, sum_, team);
  mesh_.spread(tiles_, team);
  mesh_.solve(team);
  mesh_.add(tiles_, sum_, team);
  fill(sources, tiles_, sum_, response);
  if (!std::isfinite(response.energy))
    throw InputError("The energy of the charges is no finite number: two of them lie at the same place.");
}

}  // namespace lichtenberg::periodic
