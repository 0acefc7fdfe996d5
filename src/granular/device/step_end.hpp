#pragma once

// End of an outer step (from one evaluation of the smooth forces to the next) on an executor: corrected momenta, and
// the results from which the next step is chosen.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/parallel/ranks.hpp"
#include "src/granular/device/state.hpp"

namespace lichtenberg::granular::device {

/// Computes the bound on impact speeds by elastic energy after the last contact substep. Compares the ended contacts
/// with the restitution coefficient of the law. `steps`: ContactSteps or RoughContactSteps; `grains`: their number.
template <class Executor, class Steps>
void find_impact_speeds(const Executor& run, const Steps& steps, int grains) {
  StepResults* results = steps.results;
  const int parts = std::max(grains / 16, 1);
  run.sum_segments(
      parts,
      [=] LICHTENBERG_HOST_DEVICE(int p) {
        const int share = (results->pairs + parts - 1) / parts, left = results->pairs - p * share;
        return left < share ? left : share;
      },
      [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
        return MaxReduction{steps.impact2(p * ((results->pairs + parts - 1) / parts) + t)};
      },
      [=] LICHTENBERG_HOST_DEVICE(int, MaxReduction most) { parallel::max_atomically(&results->impact2, most.value); });
  run.for_each(steps.restitution.capacity, [=] LICHTENBERG_HOST_DEVICE(int k) { steps.count_end(k); });
}

/// Ends an outer step of the own grains: corrects momenta for a linear change of the smooth forces, and adds exchanged
/// charges. Computes the maxima from which the next step is chosen, and then calls action(). `force`: smooth forces at
/// the end.
template <class Executor, class Action>
void finish_step(GasState<Executor>& gas, const ForceView& force, const StepParameters* parameters,
                 StepResults* results, Action action) {
  const GrainsView g = gas.view();
  const double quantum = gas.units.charge;
  FieldEnergyBudget* budget = gas.field_energy.data();
  const Vec3 units_per_length = gas.units_per_length();
  const int first = gas.share.range().own.first;
  gas.run->template sum<1>(
      gas.share.range().own.count,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        const int s = first + k;
        const Vec3 now = force(s), at = g.position[s];
        const Vec3 p = g.momentum[s] + (0.5 * parameters->outer) * (now - g.slow_force[s]);
        g.momentum[s] = p, g.slow_force[s] = now;
        std::int64_t& moved = g.moved_charge[s];
        if (moved != 0) g.charge[s] += quantum * static_cast<double>(moved), moved = 0;
        const FixedPointPosition from = g.sorted_at[s], to = fixed_point_position(at, units_per_length);
        const Vec3 path{lichtenberg::nearest_difference(to.x, from.x) / units_per_length.x,
                        lichtenberg::nearest_difference(to.y, from.y) / units_per_length.y,
                        lichtenberg::nearest_difference(to.z, from.z) / units_per_length.z};
        StepMaxima here;
        here.speed2 = norm2(g.inverse_mass[s] * p), here.acceleration2 = norm2(g.inverse_mass[s] * now);
        here.moved2 = norm2(path), here.charge = std::abs(g.charge[s]);
        here.lost = !(here.speed2 < INFINITY) || !(norm2(at) < INFINITY);
        return here;
      },
      [=] LICHTENBERG_HOST_DEVICE(StepMaxima most) {
        results->speed2 = most.speed2, results->acceleration2 = most.acceleration2;
        results->moved2 = most.moved2, results->charge = most.charge;
        results->lost = most.lost;
        budget->energy = force.energy();
        // The ended contacts are in the statistics now. Reset, so that a graph without a step does not count them
        // again.
        results->ended = 0;
        action();
      });
}

/// Joins the results `mine` of a step of all ranks, so that each rank has the sums and maxima. `others`: memory for the
/// results of the other ranks.
template <class Executor>
void join_results(const Executor& run, StepResults* mine, parallel::Array<StepResults, Executor>& others) {
  const int rank = run.rank(), ranks = run.ranks();
  others.resize(ranks);
  StepResults* all = others.data();
  std::vector<parallel::Transfer> transfers;
  for (int r = 0; r < ranks; ++r) {
    if (r == rank) continue;
    transfers.push_back({mine, sizeof(StepResults), r, true});
    transfers.push_back({all + r, sizeof(StepResults), r, false});
  }
  run.exchange(transfers);
  run.for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) {
    StepResults results = *mine;
    for (int r = 0; r < ranks; ++r)
      if (r != rank) results.join(all[r]);
    *mine = results;
  });
}

}  // namespace lichtenberg::granular::device
