#pragma once

// Fields on several devices of one host (README.md, "Several devices"). Each device has a rank, arrays of all cells,
// and the values of all groups. It computes the cells in its own rows, and receives those of a few rows next to them.
// Sums over cells are added in the order of the ranks, so that all ranks have the same bits.

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/device/relax_clusters.hpp"
#include "solvers/parallel/ranks.hpp"

namespace lichtenberg::laplace::device {

/// Numbers of rows next to the own ones that kernels read. They read right-hand sides in Descend and Ascend, potentials
/// of the coarse grid in Ascend, and potentials in a product with the operator.
constexpr int ghosts_of_rhs = 3, ghosts_of_correction = 2, ghosts_of_product = 1;

/// Sends values by slot (memory index) of own rows to the ranks that read them: up to `ghosts` rows on either side of
/// their own; ny: all rows. `values`: an array of the grid.
template <class Executor, class T>
void exchange_rows(const Executor& run, const GridView& grid, T* values, int ghosts) {
  const Layout& at = grid.layout;
  const int ranks = grid.rows.ranks, mine = run.rank();
  if (ranks == 1) return;
  std::vector<parallel::Transfer> transfers;
  const auto add = [&](int from, int to, Rows wanted) {
    const Rows both{std::max(wanted.begin, grid.rows.border(at.ny, from)),
                    std::min(wanted.end, grid.rows.border(at.ny, from + 1))};
    if (from == to || (from != mine && to != mine) || both.count() <= 0) return;
    for (int colour = 0; colour < 2; ++colour)
      transfers.push_back({values + at.row(colour, both.begin) - Layout::pad, both.count() * at.stride * sizeof(T),
                           from == mine ? to : from, from == mine});
  };
  for (int to = 0; to < ranks; ++to) {
    const int begin = grid.rows.border(at.ny, to), end = grid.rows.border(at.ny, to + 1);
    for (int from = 0; from < ranks; ++from) {
      add(from, to, {begin - ghosts, begin});
      add(from, to, {end, std::min(at.ny, end) + ghosts});
    }
  }
  run.exchange(transfers);
}
/// As exchange_rows(), unless each rank computes all rows of the grid.
template <class Executor, class T>
void exchange_ghosts(const Executor& run, const GridView& grid, T* values, int ghosts) {
  if (grid.layout.is_divided()) exchange_rows(run, grid, values, ghosts);
}

/// Returns the memory for n values of each rank, at rank * n.
template <class T>
T* values_of_ranks(const GridView& grid) {
  static_assert(alignof(T) <= alignof(double));
  return reinterpret_cast<T*>(grid.from_ranks);
}
/// Sends this rank's n values in values_of_ranks() to all ranks, and calls finish(k, sum) for each k with the sum of
/// the k-th values of all ranks.
template <class Sum, class Executor, class Finish>
void add_ranks(const Executor& run, const GridView& grid, long n, Finish finish) {
  Sum* all = values_of_ranks<Sum>(grid);
  const int ranks = run.ranks(), count = static_cast<int>(n);
  run.gather(all, n);
  run.template for_each<32>(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
    Sum sum = all[k];
    for (int r = 1; r < ranks; ++r) sum += all[r * count + k];
    finish(k, sum);
  });
}

/// Entries of a vector that a rank computes: slots (memory indices) of its rows by colour, then all groups (bodies with
/// one potential).
struct OwnEntries {
  int a_colour, red, black, cells, groups;

  OwnEntries(const Layout& at, int groups_)
      : a_colour(static_cast<int>(at.own.count() * at.stride)),
        red(static_cast<int>(at.row(0, at.own.begin)) - Layout::pad),
        black(static_cast<int>(at.row(1, at.own.begin)) - Layout::pad),
        cells(static_cast<int>(at.size())),
        groups(groups_) {}
  long count() const { return 2L * a_colour + groups; }
  /// Returns the index in a vector of the k-th entry.
  LICHTENBERG_HOST_DEVICE int operator()(int k) const {
    if (k < a_colour) return red + k;
    return k < 2 * a_colour ? black + k - a_colour : cells + k - 2 * a_colour;
  }
};
/// Calls f(k) for each entry k of a vector, by slot (memory index) and then by group; on a divided grid for those of
/// this rank. `groups`: their number, 0 for a vector of cells only.
template <class Executor, class F>
void for_each_entry(const Executor& run, const GridView& grid, int groups, F f) {
  const Layout& at = grid.layout;
  if (!at.is_divided()) return run.for_each(static_cast<long>(at.size()) + groups, f);
  const OwnEntries own(at, groups);
  run.for_each(own.count(), [=] LICHTENBERG_HOST_DEVICE(int k) { f(own(k)); });
}
/// Calls finish(sum) with the sum of value(k) over all entries k of a vector.
template <class Executor, class Value, class Finish>
void sum_of_vector(const Executor& run, const GridView& grid, int groups, Value value, Finish finish) {
  using Sum = decltype(value(0));
  const Layout& at = grid.layout;
  if (!at.is_divided()) return run.sum(static_cast<long>(at.size()) + groups, value, finish);
  const OwnEntries own(at, at.is_first() ? groups : 0);
  Sum* mine = values_of_ranks<Sum>(grid) + run.rank();
  run.sum(
      own.count(), [=] LICHTENBERG_HOST_DEVICE(int k) { return value(own(k)); },
      [=] LICHTENBERG_HOST_DEVICE(const Sum& sum) { *mine = sum; });
  add_ranks<Sum>(run, grid, 1, [=] LICHTENBERG_HOST_DEVICE(int, const Sum& sum) { finish(sum); });
}

/// List of items of cells, with the pieces that belong to each group (bodies with one potential). `slot`: cell (memory
/// index) of each item; `partial`: memory for one sum per piece.
template <class Sum>
struct CellPieces {
  parallel::SegmentPieces pieces;
  const int* slot;
  Sum* partial;
};
/// Returns the links (conductances to fluid cells) of all groups (bodies with one potential).
template <class Sum>
CellPieces<Sum> links_by_group(const ProblemView& problem, const GridView& grid, Sum* partial) {
  return {grid.link_pieces(problem), grid.links.slot, partial};
}

/// Calls finish(g, sum) for each group g (bodies with one potential). The sum is that of value(item) over the group's
/// items on all ranks, and of more.value(g, t) for t = 0 ... more.count(g) - 1.
template <class Sum, class Executor, class Value, class More, class Finish>
void sum_by_group(const Executor& run, const GridView& grid, const CellPieces<Sum>& items, Value value, More more,
                  Finish finish) {
  if (!grid.layout.is_divided()) return run.sum_pieces(items.pieces, items.partial, value, more, finish);
  const Layout at = grid.layout;
  const int *slot = items.slot, groups = items.pieces.segments, ranks = run.ranks();
  Sum *all = values_of_ranks<Sum>(grid), *mine = all + run.rank() * groups;
  run.sum_pieces(
      items.pieces, items.partial,
      [=] LICHTENBERG_HOST_DEVICE(int k) { return at.owns(slot[k]) ? static_cast<Sum>(value(k)) : Sum{}; },
      parallel::NoAddedValues{}, [=] LICHTENBERG_HOST_DEVICE(int g, Sum sum) { mine[g] = sum; });
  run.gather(all, groups);
  run.template sum_segments<group_lanes>(
      groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return more.count(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return static_cast<Sum>(more.value(g, t)); },
      [=] LICHTENBERG_HOST_DEVICE(int g, Sum sum) {
        for (int r = 0; r < ranks; ++r) sum += all[r * groups + g];
        finish(g, sum);
      });
}
/// Segments of a sum: n segments, of which segment s has count(s) terms.
template <class Count>
struct Segments {
  int n;
  Count count;
};
/// Calls finish(s, sum) for each segment s with the sum of value(s, t) over its terms t. On a divided grid each rank
/// adds the terms for which is_own(s, t) is true.
template <class Executor, class Count, class Value, class IsOwn, class Finish>
void sum_segments_of_ranks(const Executor& run, const GridView& grid, const Segments<Count>& segments, Value value,
                           IsOwn is_own, Finish finish) {
  using Sum = decltype(value(0, 0));
  const int n = segments.n;
  if (!grid.layout.is_divided()) return run.sum_segments(n, segments.count, value, finish);
  Sum* mine = values_of_ranks<Sum>(grid) + run.rank() * n;
  run.sum_segments(
      n, segments.count, [=] LICHTENBERG_HOST_DEVICE(int s, int t) { return is_own(s, t) ? value(s, t) : Sum{}; },
      [=] LICHTENBERG_HOST_DEVICE(int s, const Sum& sum) { mine[s] = sum; });
  add_ranks<Sum>(run, grid, n, finish);
}

}  // namespace lichtenberg::laplace::device
