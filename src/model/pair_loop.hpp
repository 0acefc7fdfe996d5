#pragma once

// Loops over pairs of particles on the host, for any law (pair_law.hpp).

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/parallel/team.hpp"
#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// Index of a particle, and a force on it (N).
struct ParticleForce {
  int particle = 0;
  std::array<double, 3> force{};
};

/// Total energy of a loop over pairs, and the first pair for which the force law is not valid.
struct PairSum {
  double energy = 0;            ///< in multiples of the law's energy_unit()
  std::optional<Pair> refused;  ///< empty if the law is valid for all pairs
};

/// Output of a loop over the pairs whose first particle is in a range of particles. Forces on particles of the range
/// are added to `force`, and forces on other particles are appended to `outside`. The energy is added to `sum`.
struct PairOutput {
  std::span<double> force;  ///< N, [N * d]
  std::vector<ParticleForce>& outside;
  PairSum& sum;
};

/// Range of successive particles: first <= i < end.
struct ParticleRange {
  int first = 0, end = 0;
};

/// A pair of particles within the cutoff of a pair force law: indices, separation vector and input of the law.
template <int d>
struct PairInReach {
  Pair pair;
  Vec<d> separation;  ///< m, from particle j to particle i
  PairGeometry geometry;
};

/// Returns the part of `pairs` whose first particle i is in the range. `pairs` is in ascending order.
inline std::span<const Pair> pairs_of(std::span<const Pair> pairs, const ParticleRange& range) {
  const auto from = std::ranges::lower_bound(pairs, range.first, {}, &Pair::i);
  return {from, std::ranges::lower_bound(from, pairs.end(), range.end, {}, &Pair::i)};
}

namespace pair_loop {

/// Batch of particle pairs within the cutoff of a pair force law, stored as one array for each quantity so that the
/// compiler vectorizes the evaluation of the law. Use: gather(), apply_law(), add_forces().
template <int d, PairLaw Law, bool periodic>
class Batch {
 public:
  static constexpr std::size_t most = 256;  ///< largest number of pairs

  Batch(const Law& law, const Spheres<d>& spheres) : law_(law), spheres_(spheres), nearest_(spheres.box) {}

  /// Replaces the batch by the elements of `pairs` (at most `most`) that are within the cutoff.
  void gather(std::span<const Pair> pairs) {
    const double *p = spheres_.position.data(), *radius = spheres_.radius.data();
    [[maybe_unused]] const double* charge = spheres_.charge.data();
    count_ = 0;
    for (const Pair pair : pairs) {  // no branch, because pairs within the cutoff are hard to predict
      double sum = 0;
      for (int k = 0; k < d; ++k) {
        double separation = p[pair.i * d + k] - p[pair.j * d + k];
        if constexpr (periodic) separation = nearest_(separation, k);
        direction_[k][count_] = separation;
        sum += separation * separation;
      }
      const double reach = law_.reach(radius[pair.i], radius[pair.j]);
      pair_[count_] = pair;
      squared_[count_] = sum;
      reach_[count_] = reach;
      radius_i_[count_] = radius[pair.i];
      radius_j_[count_] = radius[pair.j];
      if constexpr (Law::charged) charge_i_[count_] = charge[pair.i], charge_j_[count_] = charge[pair.j];
      count_ += sum < reach * reach;
    }
  }

  /// Evaluates the force law for each pair of the batch. Adds the energies to sum.energy sequentially, so that the sum
  /// does not depend on the division into batches. Sets sum.refused, if empty, to the first pair for which the law is
  /// not valid.
  void apply_law(PairSum& sum) {
    int rest = 0, refused = 0;
    for (int c = 0; c < count_; ++c) {
      const PairGeometry pair = geometry(c);
      if constexpr (HasQuick<Law>) {
        store_force(c, law_.quick(pair));
        rest |= !law_.quick_holds(pair);
      } else {
        store_force(c, law_(pair));
      }
      if constexpr (CanRefuse<Law>) refused |= law_.refuses(pair);
    }
    if constexpr (HasQuick<Law>)
      for (int c = 0; rest && c < count_; ++c)
        if (const PairGeometry pair = geometry(c); !law_.quick_holds(pair)) store_force(c, law_(pair));
    if constexpr (CanRefuse<Law>)
      for (int c = 0; refused && !sum.refused && c < count_; ++c)
        if (law_.refuses(geometry(c))) sum.refused = pair_[c];
    for (int c = 0; c < count_; ++c) {
      sum.energy += energy_[c];
      for (int k = 0; k < d; ++k)
        if constexpr (Law::over_distance)
          direction_[k][c] *= force_[c];
        else
          direction_[k][c] /= distance_[c];
    }
  }

  /// Adds the pair forces of the batch to `force` (N, [N * d]). Forces on a second particle j >= end are appended to
  /// `outside` instead. `all`: there is no pair with j >= end.
  template <bool all>
  void add_forces(int end, std::span<double> force, std::vector<ParticleForce>& outside) const {
    for (int c = 0; c < count_; ++c) {
      const auto [i, j] = pair_[c];
      for (int k = 0; k < d; ++k) force[i * d + k] += force_component(c, k);
      if (all || j < end) {
        for (int k = 0; k < d; ++k) force[j * d + k] -= force_component(c, k);
      } else {
        outside.push_back({j});
        for (int k = 0; k < d; ++k) outside.back().force[k] = -force_component(c, k);
      }
    }
  }

 private:
  PairGeometry geometry(int c) const {
    const double distance = std::sqrt(squared_[c]);
    PairGeometry pair{distance, reach_[c], radius_i_[c], radius_j_[c]};
    if constexpr (Law::charged) pair.charge_i = charge_i_[c], pair.charge_j = charge_j_[c];
    return pair;
  }
  void store_force(int c, const PairForce& law) {
    energy_[c] = law.energy;
    force_[c] = law.force;
    if constexpr (!Law::over_distance) distance_[c] = std::sqrt(squared_[c]);
  }
  double force_component(int c, int k) const {
    return Law::over_distance ? direction_[k][c] : force_[c] * direction_[k][c];
  }

  using Numbers = std::array<double, most>;
  const Law& law_;
  const Spheres<d>& spheres_;
  NearestImage<d> nearest_;
  int count_ = 0;
  std::array<Pair, most> pair_;
  Numbers squared_, reach_, radius_i_, radius_j_;                    // m^2, m, m, m
  Numbers energy_, force_, distance_;                                // as in PairForce; m
  std::array<double, Law::charged ? most : 0> charge_i_, charge_j_;  // C
  // m, from j to i; after apply_law a unit vector, or N if the law is `over_distance`
  std::array<Numbers, d> direction_;
};

/// Adds the forces and energies of `pairs` to `output`, in batches. Forces on second particles j >= end are appended to
/// output.outside.
template <bool periodic, bool all, int d, PairLaw Law>
void add_range(const Law& law, const Spheres<d>& spheres, std::span<const Pair> pairs, int end,
               const PairOutput& output) {
  Batch<d, Law, periodic> batch(law, spheres);
  while (!pairs.empty()) {
    const std::span now = pairs.first(std::min(pairs.size(), batch.most));
    pairs = pairs.subspan(now.size());
    batch.gather(now);
    batch.apply_law(output.sum);
    batch.template add_forces<all>(end, output.force, output.outside);
  }
}

/// Implements for_each_in_reach() for a box with or without periodic axes.
template <bool periodic, int d, PairLaw Law, class Visit>
bool visit(const Law& law, const Spheres<d>& spheres, std::span<const Pair> pairs, Visit&& use) {
  const NearestImage<d> nearest(spheres.box);
  for (const Pair pair : pairs) {
    PairInReach<d> found{.pair = pair};
    double sum = 0;
    for (int k = 0; k < d; ++k) {
      double separation = spheres.position[pair.i * d + k] - spheres.position[pair.j * d + k];
      if constexpr (periodic) separation = nearest(separation, k);
      found.separation[k] = separation;
      sum += separation * separation;
    }
    const double radius_i = spheres.radius[pair.i], radius_j = spheres.radius[pair.j];
    const double reach = law.reach(radius_i, radius_j);
    if (!(sum < reach * reach)) continue;
    if (sum == 0) return false;
    found.geometry = {std::sqrt(sum), reach, radius_i, radius_j};
    if constexpr (Law::charged)
      found.geometry.charge_i = spheres.charge[pair.i], found.geometry.charge_j = spheres.charge[pair.j];
    use(found);
  }
  return true;
}

}  // namespace pair_loop

/// Calls use(PairInReach) for every element of `pairs` within the cutoff of a pair force law, in their order. Returns
/// true at the end, or stops and returns false at a pair whose centres coincide.
template <int d, PairLaw Law, class Visit>
bool for_each_in_reach(const Law& law, const Spheres<d>& spheres, std::span<const Pair> pairs, Visit&& use) {
  return spheres.box.any_periodic() ? pair_loop::visit<true>(law, spheres, pairs, use)
                                    : pair_loop::visit<false>(law, spheres, pairs, use);
}

/// Adds the derivatives (N/m) of the forces on both particles of a pair by both positions to a ForceJacobian.
template <int d, PairLaw Law, class Jacobian>
void add_pair_derivatives(const Law& law, const PairInReach<d>& pair, Jacobian& jacobian) {
  const PairForce of = law(pair.geometry);
  std::array<double, d> normal;
  for (int k = 0; k < d; ++k) normal[k] = pair.separation[k] / pair.geometry.distance;
  // Moving i away from j reduces the force. Moving i sideways rotates the force, with the distance as arm.
  const double along = -of.stiffness, across = over_distance<Law>(of, pair.geometry.distance);
  const auto [i, j] = pair.pair;
  jacobian.add_central(i, i, normal, along, across);
  jacobian.add_central(j, j, normal, along, across);
  jacobian.add_central(i, j, normal, -along, -across);
  jacobian.add_central(j, i, normal, -along, -across);
}

/// Adds the forces and energies of the pairs whose first particle is in `range` to `output`, for callers that divide
/// the particles among threads. `pairs`: neighbour pairs in ascending order; pairs beyond the law's cutoff are skipped.
template <int d, PairLaw Law>
void add_pair_forces(const Law& law, const Spheres<d>& spheres, std::span<const Pair> pairs, const ParticleRange& range,
                     const PairOutput& output) {
  pairs = pairs_of(pairs, range);
  const bool all = range.first == 0 && range.end == spheres.size();
  const auto add = [&]<bool periodic>(std::bool_constant<periodic>) {
    all ? pair_loop::add_range<periodic, true>(law, spheres, pairs, range.end, output)
        : pair_loop::add_range<periodic, false>(law, spheres, pairs, range.end, output);
  };
  spheres.box.any_periodic() ? add(std::true_type{}) : add(std::false_type{});
}

/// Adds the forces of all pairs to `force` (N, [N * d]), on the threads of a team. Returns the total energy and the
/// first pair for which the law is not valid. `pairs`: neighbour pairs in ascending order; pairs beyond the law's
/// cutoff are skipped. The result is bitwise identical for any number of threads.
template <int d, PairLaw Law>
PairSum add_pair_forces(const Law& law, const Spheres<d>& spheres, std::span<const Pair> pairs, std::span<double> force,
                        parallel::Team& team) {
  constexpr int particles_a_task = 2048;
  const int n = spheres.size(), tasks = (n + particles_a_task - 1) / particles_a_task;
  PairSum sum;
  if (tasks <= 1) {
    std::vector<ParticleForce> none;
    add_pair_forces(law, spheres, pairs, ParticleRange{0, n}, PairOutput{force, none, sum});
    return sum;
  }
  // Each task has a range of particles. Its forces on other particles are added afterwards, in the order of the tasks.
  std::vector<PairSum> sums(tasks);
  std::vector<std::vector<ParticleForce>> outside(tasks);
  team.for_each(tasks, [&](int task) {
    const int first = task * particles_a_task;
    const ParticleRange range{first, std::min(n, first + particles_a_task)};
    add_pair_forces(law, spheres, pairs, range, PairOutput{force, outside[task], sums[task]});
  });
  for (int task = 0; task < tasks; ++task) {
    sum.energy += sums[task].energy;
    if (!sum.refused) sum.refused = sums[task].refused;
    for (const ParticleForce& one : outside[task])
      for (int k = 0; k < d; ++k) force[one.particle * d + k] += one.force[k];
  }
  return sum;
}

}  // namespace lichtenberg
