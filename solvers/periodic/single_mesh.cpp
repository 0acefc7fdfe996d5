#include "solvers/periodic/single_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/felt.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg::periodic {

namespace {

double checked_cutoff_of(const Mesh& mesh, const Cloud& cloud) {
  if (cloud.cutoff > SingleNear::longest_cutoff(mesh.lengths))
    throw InputError(fmt::format("a cut-off of {} is more than a third of the box of {} x {} x {}", cloud.cutoff,
                                 mesh.lengths.x, mesh.lengths.y, mesh.lengths.z));
  return cloud.cutoff;
}

/// Sums over some charges: of forces, of charge^2 and of energy.
using Part = std::array<double, 5>;

}  // namespace

SingleMesh::SingleMesh(const Mesh& mesh, const Cloud& cloud, int charges)
    : lengths_(mesh.lengths),
      cutoff_(checked_cutoff_of(mesh, cloud)),
      near_(mesh.lengths, cloud),
      mesh_(mesh, cloud),
      columns_(mesh.lengths, charges, SingleNear::together, SingleNear::longest_cutoff(mesh.lengths),
               std::max(cutoff_, mesh_.reach())) {}

void SingleMesh::require_usable(const Sources& sources) const {
  require_consistent(sources);
  if (sources.lengths != lengths_)
    throw InputError(fmt::format("the box is {} x {} x {} long, but the mesh was made for {} x {} x {}",
                                 sources.lengths.x, sources.lengths.y, sources.lengths.z, lengths_.x, lengths_.y,
                                 lengths_.z));
  if (!sources.dipole.empty()) throw InputError("there are no dipoles on a mesh in single precision");
}

void SingleMesh::evaluate(const Sources& sources, std::span<const Pair>, parallel::Team& team, Response& response) {
  compute(sources, true, team);
  const Stopwatch stopwatch(seconds_.mesh);
  resize(response, sources.size());
  fill(sources, team, response.force, &response);
}

void SingleMesh::forces(const Sources& sources, std::span<const Pair>, parallel::Team& team,
                        std::vector<double>& force) {
  compute(sources, false, team);
  const Stopwatch stopwatch(seconds_.mesh);
  force.resize(3 * sources.charge.size());
  fill(sources, team, force, nullptr);
}

void SingleMesh::compute(const Sources& sources, bool potentials, parallel::Team& team) {
  require_usable(sources);
  {
    const Stopwatch stopwatch(seconds_.near);
    columns_.sort(sources, team);
    sums_.resize(4 * sources.charge.size());
    near_.compute(columns_, potentials, sums_, team);
  }
  const Stopwatch stopwatch(seconds_.mesh);
  mesh_.spread(columns_, team);
  mesh_.solve(team);
  mesh_.add(columns_, sums_, team);
}

/// The mean force is taken off with the least change of the field that does.
void SingleMesh::fill(const Sources& sources, parallel::Team& team, std::vector<double>& force, Response* rest) {
  constexpr int charges_a_task = 1024;
  const int n = sources.size(), tasks = (n + charges_a_task - 1) / charges_a_task;
  const double by_potential = columns_.charge_unit() / cutoff_, by_field = by_potential / cutoff_;
  std::vector<Part> parts(tasks);
  const int* sorted = columns_.sorted();
  const float* sums = sums_.data();
  const auto add_up = [&] [[gnu::noinline]] (int task) {
    Part part{};
    for (int i = task * charges_a_task; i < std::min(n, (task + 1) * charges_a_task); ++i) {
      const float* felt = &sums[4 * static_cast<std::size_t>(sorted[i])];
      const double charge = sources.charge[i];
      for (int k = 0; k < 3; ++k) part[k] += charge * (by_field * felt[k]);
      part[3] += charge * charge;
      part[4] += 0.5 * charge * (by_potential * felt[3]);
    }
    parts[task] = part;
  };
  team.for_each(tasks, add_up);
  Part all{};
  for (const Part& part : parts)
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += part[k];
  std::array<double, 3> off{};
  for (int k = 0; k < 3 && all[3] > 0; ++k) off[k] = all[k] / all[3];
  const auto fill_task = [&] [[gnu::noinline]] (int task) {
    for (int i = task * charges_a_task; i < std::min(n, (task + 1) * charges_a_task); ++i) {
      const float* felt = &sums[4 * static_cast<std::size_t>(sorted[i])];
      const double charge = sources.charge[i];
      for (int k = 0; k < 3; ++k) force[3 * i + k] = charge * (by_field * felt[k] - charge * off[k]);
      if (!rest) continue;
      for (int k = 0; k < 3; ++k) rest->field[3 * i + k] = by_field * felt[k];
      rest->potential[i] = by_potential * felt[3];
    }
  };
  team.for_each(tasks, fill_task);
  if (rest) rest->energy = all[4];
  if (!std::isfinite(all[0] + all[1] + all[2] + all[4]))
    throw InputError("the energy of the charges is no finite number: two of them lie at the same place");
}

}  // namespace lichtenberg::periodic
