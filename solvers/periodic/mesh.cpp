#include "solvers/periodic/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/field_sums.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg::periodic {

template <class Real>
MeshSum<Real>::MeshSum(const Mesh& mesh, const Cloud& cloud)
    : lengths_(mesh.lengths),
      near_(mesh.lengths, cloud),
      mesh_(mesh, cloud),
      columns_(mesh.lengths, near_.layout(mesh_.reach(), mesh.open.volume)) {}

template <class Real>
void MeshSum<Real>::require_usable(const Sources& sources) const {
  require_consistent(sources);
  if (sources.lengths != lengths_)
    throw InputError(fmt::format("the box is {} x {} x {} long, but the mesh was made for {} x {} x {}",
                                 sources.lengths.x, sources.lengths.y, sources.lengths.z, lengths_.x, lengths_.y,
                                 lengths_.z));
  if (sources.dipole.empty()) return;
  if (sizeof(Real) == 4) throw InputError("there are no dipoles on a mesh in single precision");
  if (mesh_.order() < lowest_dipole_order)
    throw InputError(fmt::format("dipoles on a mesh need splines of order {} at least: these are of order {}",
                                 lowest_dipole_order, mesh_.order()));
}

template <class Real>
void MeshSum<Real>::evaluate(const Sources& sources, std::span<const Pair>, parallel::Team& team, Response& response) {
  compute(sources, sources.dipole.empty() ? Kind::charges : Kind::multipoles, true, team);
  const Stopwatch stopwatch(seconds_.mesh);
  resize(response, sources.size());
  fill(sources, team, response.force, &response);
}

template <class Real>
void MeshSum<Real>::forces(const Sources& sources, std::span<const Pair>, parallel::Team& team,
                           std::vector<double>& force) {
  compute(sources, sources.dipole.empty() ? Kind::charges : Kind::multipoles, false, team);
  const Stopwatch stopwatch(seconds_.mesh);
  force.resize(3 * sources.charge.size());
  fill(sources, team, force, nullptr);
}

template <class Real>
void MeshSum<Real>::dipole_field(const Sources& sources, std::span<const Pair>, parallel::Team& team,
                                 std::span<double> field) {
  compute(sources, Kind::dipoles, false, team);
  const double unit = columns_.charge_unit() / (near_.cutoff() * near_.cutoff());
  for (int i = 0; i < sources.size(); ++i)
    for (int k = 0; k < 3; ++k) field[3 * i + k] = unit * field_[4 * columns_.sorted()[i] + k];
}

template <class Real>
void MeshSum<Real>::compute(const Sources& sources, Kind kind, bool potentials, parallel::Team& team) {
  require_usable(sources);
  field_.resize(4 * sources.charge.size());
  force_.resize(kind == Kind::multipoles ? field_.size() : 0);
  const FieldSums<Real> sums{field_, force_};
  {
    const Stopwatch stopwatch(seconds_.near);
    columns_.sort(sources, team);
    near_.compute(columns_, kind, potentials, sums, team);
  }
  const Stopwatch stopwatch(seconds_.mesh);
  mesh_.spread(columns_, kind, team);
  mesh_.solve(team);
  mesh_.add(columns_, kind, sums, team);
}

/// Force on a source: `factor` times a field, which is `on_unit` less `share` times the field that is subtracted to
/// make the net force 0.
template <class Real>
struct MeshSum<Real>::Acting {
  const Real* on_unit;
  double factor, share;
};

/// The net force is subtracted in shares proportional to the squared charge. A dipole counts as two charges separated
/// by the mesh's reach.
template <class Real>
typename MeshSum<Real>::Acting MeshSum<Real>::acting_on(const Sources& sources, int i) const {
  const std::size_t at = 4 * static_cast<std::size_t>(columns_.sorted()[i]);
  const double charge = sources.charge[i];
  if (force_.empty()) return {&field_[at], charge, charge};
  const double dipole2 = norm2(multipole(sources, i).dipole) / (mesh_.reach() * mesh_.reach());
  return {&force_[at], columns_.charge_unit(), (charge * charge + dipole2) / columns_.charge_unit()};
}

/// Returns sums over some sources: forces (3), their shares, and energies.
template <class Real>
[[gnu::noinline]] std::array<double, 5> MeshSum<Real>::totals_of(const Sources& sources, int first, int end) const {
  const double by_potential = columns_.charge_unit() / near_.cutoff(), by_field = by_potential / near_.cutoff();
  std::array<double, 5> totals{};
  for (int i = first; i < end; ++i) {
    const auto [on_unit, factor, share] = acting_on(sources, i);
    for (int k = 0; k < 3; ++k) totals[k] += factor * (by_field * on_unit[k]);
    totals[3] += factor * share;
    const Real* sample = &field_[4 * static_cast<std::size_t>(columns_.sorted()[i])];
    totals[4] += 0.5 * sources.charge[i] * (by_potential * sample[3]);
    for (int k = 0; k < 3 && !force_.empty(); ++k)
      totals[4] -= 0.5 * sources.dipole[3 * i + k] * (by_field * sample[k]);
  }
  return totals;
}

/// Subtracts the net force with the least change of the field, in the sense of least squares.
template <class Real>
void MeshSum<Real>::fill(const Sources& sources, parallel::Team& team, std::vector<double>& force, Response* rest) {
  constexpr int sources_a_task = 1024;
  const int n = sources.size(), tasks = (n + sources_a_task - 1) / sources_a_task;
  const double by_potential = columns_.charge_unit() / near_.cutoff(), by_field = by_potential / near_.cutoff();
  std::vector<std::array<double, 5>> parts(tasks);
  team.for_each(tasks, [&](int task) {
    parts[task] = totals_of(sources, task * sources_a_task, std::min(n, (task + 1) * sources_a_task));
  });
  std::array<double, 5> all{};
  for (const auto& part : parts)
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += part[k];
  std::array<double, 3> off{};
  for (int k = 0; k < 3 && all[3] > 0; ++k) off[k] = all[k] / all[3];
  const auto fill_task = [&] [[gnu::noinline]] (int task) {
    for (int i = task * sources_a_task; i < std::min(n, (task + 1) * sources_a_task); ++i) {
      const auto [on_unit, factor, share] = acting_on(sources, i);
      for (int k = 0; k < 3; ++k) force[3 * i + k] = factor * (by_field * on_unit[k] - share * off[k]);
      if (!rest) continue;
      const Real* sample = &field_[4 * static_cast<std::size_t>(columns_.sorted()[i])];
      for (int k = 0; k < 3; ++k) rest->field[3 * i + k] = by_field * sample[k];
      rest->potential[i] = by_potential * sample[3];
    }
  };
  team.for_each(tasks, fill_task);
  if (rest) rest->energy = all[4];
  if (!std::isfinite(all[0] + all[1] + all[2] + all[4]))
    throw InputError("the energy of the charges is not finite: two of them have the same position");
}

template class MeshSum<float>;
template class MeshSum<double>;

}  // namespace lichtenberg::periodic
