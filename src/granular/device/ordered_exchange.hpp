#pragma once

// Transfers of charge that depend on earlier ones. They take place at the end of an outer step. Their order is that
// of the CPU (effects::ChargeExchange): by substeps, and in a substep by the indices of the grains in the scene.

#include "src/effects/charge_exchange_law.hpp"
#include "src/granular/device/contact_steps.hpp"

namespace lichtenberg::granular::device {

/// Kernel that transfers charge in the contacts that have begun in an outer step. A contact is due when all
/// earlier ones of both grains are done. All due contacts transfer charge in parallel, in rounds, so that the result is
/// that of the order. A grain has few new contacts, so there are few rounds.
template <class Law>
struct OrderedExchange {
  ContactSteps<Law> steps;
  effects::CollisionExchange exchange;
  const double* affinity;  ///< of each grain by its number; null: not needed
  const int* go;           ///< 0: no step has been chosen

  template <class Grid>
  LICHTENBERG_HOST_DEVICE void operator()(const Grid& grid) const {
    if (!*go) return;
    const int most = steps.contacts.table.end(steps.grains.count - 1);
    const int listed = steps.results->onsets, count = listed < most ? listed : most;
    grid.each(count, [&](int k) { link(k); });
    for (std::int64_t done = 0; done < count; done = parallel::fresh(&steps.results->transfers)) {
      grid.each(count, [&](int k) { find_due(k); });
      grid.each(count, [&](int k) { transfer(k); });
    }
    grid.each(count, [&](int k) {
      const GrainPair& p = pair(k);
      steps.grains.begun[p.lower] = steps.grains.begun[p.higher] = no_end;
    });
  }

 private:
  LICHTENBERG_HOST_DEVICE ContactOnset& onset(int k) const { return steps.contacts.onset[k]; }
  LICHTENBERG_HOST_DEVICE const GrainPair& pair(int k) const { return steps.contacts.near[onset(k).near]; }
  LICHTENBERG_HOST_DEVICE int number(int s) const { return steps.grains.number[s]; }

  /// Adds contact k to the linked lists of its grains.
  LICHTENBERG_HOST_DEVICE void link(int k) const {
    const GrainPair& p = pair(k);
    onset(k).next[0] = parallel::exchange_atomically(&steps.grains.begun[p.lower], 2 * k);
    onset(k).next[1] = parallel::exchange_atomically(&steps.grains.begun[p.higher], 2 * k + 1);
  }
  /// Returns true if contact a comes before contact b.
  LICHTENBERG_HOST_DEVICE bool precedes(int a, int b) const {
    if (onset(a).time != onset(b).time) return onset(a).time < onset(b).time;
    const int first_a = number(pair(a).lower), first_b = number(pair(b).lower);
    if (first_a != first_b) return first_a < first_b;
    return number(pair(a).higher) < number(pair(b).higher);
  }
  /// Returns true if all contacts of grain s before contact k have transferred their charge.
  LICHTENBERG_HOST_DEVICE bool is_first(int k, int s) const {
    for (int end = steps.grains.begun[s]; end != no_end; end = onset(end / 2).next[end % 2])
      if (onset(end / 2).state != ContactOnset::done && precedes(end / 2, k)) return false;
    return true;
  }
  LICHTENBERG_HOST_DEVICE void find_due(int k) const {
    if (onset(k).state == ContactOnset::waiting && is_first(k, pair(k).lower) && is_first(k, pair(k).higher))
      onset(k).state = ContactOnset::due;
  }
  /// Transfers charge in contact k if it is due.
  LICHTENBERG_HOST_DEVICE void transfer(int k) const {
    if (onset(k).state != ContactOnset::due) return;
    onset(k).state = ContactOnset::done;
    const GrainsView& g = steps.grains;
    const GrainPair& p = pair(k);
    const int i = p.lower, j = p.higher;
    const double quantum = steps.units.charge;
    const double charge_i = g.charge[i] + quantum * static_cast<double>(g.moved_charge[i]),
                 charge_j = g.charge[j] + quantum * static_cast<double>(g.moved_charge[j]);
    effects::Collision collision;
    collision.effective_mass = 1 / steps.inverse_mass(p), collision.speed = onset(k).impact_speed;
    collision.radius_i = g.radius[i], collision.radius_j = g.radius[j];
    if (affinity) collision.affinity_i = affinity[g.number[i]], collision.affinity_j = affinity[g.number[j]];
    collision.separation = -1.0 * steps.separation(p);
    collision.difference = charge_i - charge_j;
    collision.collisions_i = static_cast<double>(g.collisions[i]),
    collision.collisions_j = static_cast<double>(g.collisions[j]);
    Random random({steps.seed, RandomPurpose::exchange, static_cast<std::uint64_t>(g.number[i]),
                   static_cast<std::uint64_t>(g.number[j]), static_cast<std::uint64_t>(g.collisions[i])});
    const std::int64_t moved = rounded_to_integer(exchange(collision, random) / quantum);
    const double dq = quantum * static_cast<double>(moved);
    const bool allowed = std::abs(charge_i + dq) <= exchange.capacity && std::abs(charge_j - dq) <= exchange.capacity;
    if (allowed) g.moved_charge[i] += moved, g.moved_charge[j] -= moved;
    ++g.collisions[i], ++g.collisions[j];
    parallel::add_atomically(&steps.results->refused, std::int64_t{!allowed && moved != 0});
    parallel::add_atomically(&steps.results->unchanged, std::int64_t{!allowed || moved == 0});
    parallel::add_atomically(&steps.results->transfers, std::int64_t{1});
  }
};

/// Transfers charge in the contacts that have begun in the outer step, in their order. `affinity`: of each grain by its
/// number, or null; `go`: 0 if no step has been chosen. Both are in device memory.
template <class Law, class Executor>
void exchange_in_order(const Executor& run, const ContactSteps<Law>& steps, const effects::CollisionExchange& exchange,
                       const double* affinity, const int* go) {
  run.run_cooperative(OrderedExchange<Law>{steps, exchange, affinity, go});
}

}  // namespace lichtenberg::granular::device
