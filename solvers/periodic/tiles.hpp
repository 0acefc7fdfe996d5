#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Calls work(tile) for tiles x * tiles_y + y of the box, one or an even number along x and y. Those of every other one
/// along both axes, which reach nothing in common, are taken at a time: the same order for any number of threads.
template <class Work>
void for_each_tile_apart(int tiles_x, int tiles_y, parallel::Team& team, const Work& work) {
  const int step_x = std::min(tiles_x, 2), step_y = std::min(tiles_y, 2);
  const int rows = tiles_y / step_y, count = tiles_x / step_x * rows;
  for (int x = 0; x < step_x; ++x)
    for (int y = 0; y < step_y; ++y)
      team.for_each(count, [&](int k) { work((x + k / rows * step_x) * tiles_y + y + k % rows * step_y); });
}

/// Charges sorted by where they are: what is near each other is near in memory, and threads can share the box. A tile
/// is a column of the box along z, at least twice the `reach` wide along x and y, so that what reaches no further than
/// that from its charges reaches half of each tile around it. In a tile charges go up z by half a reach at a time, and
/// by number.
class Tiles {
 public:
  Tiles(Vec3 lengths, double reach);

  /// With their dipoles, if there are any.
  void sort(const Sources& sources);

  int size() const { return static_cast<int>(order_.size()); }
  /// Of a sorted charge: its place in the box and its charge, four numbers; its number.
  const double* place_and_charge(int s) const { return &charges_[4 * s]; }
  /// Of a sorted charge, if the sources have dipoles: four numbers, the last 0.
  const double* dipole(int s) const { return &dipoles_[4 * s]; }
  int number(int s) const { return order_[s]; }
  /// Of a charge by its number: where it is sorted.
  int sorted(int i) const { return sorted_[i]; }

  /// Calls work(first, end) for the sorted charges of each tile; what these reach is no other tile's at that time, and
  /// is reached in the same order for any number of threads.
  template <class Work>
  void for_each_apart(parallel::Team& team, const Work& work) const {
    for_each_tile_apart(tiles_[0], tiles_[1], team,
                        [&](int tile) { work(first_[tile * tiles_[2]], first_[(tile + 1) * tiles_[2]]); });
  }

 private:
  void sort_dipoles(std::span<const double> dipole);

  Vec3 lengths_;
  std::array<int, 3> tiles_;       ///< along x and y: one, or an even number; pieces of a tile along z
  std::vector<int> piece_;         ///< that a charge is in, by number
  std::vector<int> first_, next_;  ///< sorted charge of a piece
  std::vector<int> order_, sorted_;
  std::vector<double> charges_, dipoles_;
};

}  // namespace lichtenberg::periodic
