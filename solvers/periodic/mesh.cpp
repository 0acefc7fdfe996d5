#include "solvers/periodic/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/felt.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg::periodic {

ParticleMesh::ParticleMesh(const Mesh& mesh, const Cloud& cloud)
    : lengths_(mesh.lengths),
      near_(mesh.lengths, cloud),
      mesh_(mesh, cloud),
      tiles_(mesh.lengths, std::max(near_.cutoff(), mesh_.reach())) {}

void ParticleMesh::require_usable(const Sources& sources) const {
  require_consistent(sources);
  if (sources.lengths != lengths_)
    throw InputError(fmt::format("the box is {} x {} x {} long, but the mesh was made for {} x {} x {}",
                                 sources.lengths.x, sources.lengths.y, sources.lengths.z, lengths_.x, lengths_.y,
                                 lengths_.z));
  if (!sources.dipole.empty() && mesh_.order() < lowest_dipole_order)
    throw InputError(fmt::format("dipoles on a mesh need splines of order {} at least: these are of order {}",
                                 lowest_dipole_order, mesh_.order()));
}

void ParticleMesh::sum(const Sources& sources, std::span<const Pair> pairs, Kind kind, parallel::Team& team) {
  require_usable(sources);
  field_.resize(4 * sources.charge.size());
  force_.resize(kind == Kind::multipoles ? field_.size() : 0);
  const FeltSums sums{field_, force_};
  {
    const Stopwatch stopwatch(seconds_.near);
    tiles_.sort(sources);
    near_.compute(tiles_, pairs, kind, sums, team);
  }
  const Stopwatch stopwatch(seconds_.mesh);
  mesh_.spread(tiles_, kind, team);
  mesh_.solve(team);
  mesh_.add(tiles_, kind, sums, team);
}

namespace {

/// Potential and field, by number.
void fill_fields(const Tiles& tiles, FieldAndPotential sum, Response& response) {
  const int n = tiles.size();
  resize(response, n);
  for (int i = 0; i < n; ++i) {
    const double* of = &sum[4 * tiles.sorted(i)];
    std::copy_n(of, 3, &response.field[3 * i]);
    response.potential[i] = of[3];
  }
}

/// The mean force of the mesh, to be taken off with the least change of the field that does.
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

void fill_forces_of_charges(const Sources& sources, const Tiles& tiles, FieldAndPotential sum, Response& response) {
  const Vec3 off = net_force_per_charge2(tiles, sum);
  response.energy = 0;
  for (int i = 0; i < sources.size(); ++i) {
    const double charge = sources.charge[i];
    for (int k = 0; k < 3; ++k) response.force[3 * i + k] = charge * (response.field[3 * i + k] - charge * off[k]);
    response.energy += 0.5 * charge * response.potential[i];
  }
}

/// The same of charges with dipoles, which are as two charges `apart`.
void fill_forces_of_multipoles(const Sources& sources, const Tiles& tiles, const std::vector<double>& force,
                               double apart, Response& response) {
  const auto strength = [&](int i) {
    const Multipole source = multipole(sources, i);
    return source.charge * source.charge + norm2(source.dipole) / (apart * apart);
  };
  Vec3 net;
  double strengths = 0;
  for (int i = 0; i < sources.size(); ++i) {
    const double* of = &force[4 * tiles.sorted(i)];
    net += {of[0], of[1], of[2]};
    strengths += strength(i);
  }
  const Vec3 off = strengths > 0 ? net / strengths : Vec3{};
  for (int i = 0; i < sources.size(); ++i)
    for (int k = 0; k < 3; ++k) response.force[3 * i + k] = force[4 * tiles.sorted(i) + k] - strength(i) * off[k];
  response.energy = energy_of(sources, all_of(sources), response);
}

}  // namespace

void ParticleMesh::evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            Response& response) {
  const bool dipoles = !sources.dipole.empty();
  sum(sources, pairs, dipoles ? Kind::multipoles : Kind::charges, team);
  fill_fields(tiles_, field_, response);
  if (dipoles)
    fill_forces_of_multipoles(sources, tiles_, force_, mesh_.reach(), response);
  else
    fill_forces_of_charges(sources, tiles_, field_, response);
  if (!std::isfinite(response.energy))
    throw InputError("the energy of the charges is no finite number: two of them lie at the same place");
}

void ParticleMesh::dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                                std::span<double> field) {
  sum(sources, pairs, Kind::dipoles, team);
  for (int i = 0; i < sources.size(); ++i) std::copy_n(&field_[4 * tiles_.sorted(i)], 3, &field[3 * i]);
}

}  // namespace lichtenberg::periodic
