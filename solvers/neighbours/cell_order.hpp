#pragma once

#include <array>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Particles in the order of the cells that they lie in: who is near in space is near in memory. A place in that order
/// is a slot; within a cell particles ascend. For those who sort their own arrays so and look for pairs anew every few
/// steps; who keeps a list for long takes pairs.hpp.
template <int d>
class CellOrder {
 public:
  /// Sorts particles into cells at least `range` (m) wide, which all pairs closer than that, centre to centre, are then
  /// found in.
  void sort(const Spheres<d>& spheres, double range);

  int size() const { return static_cast<int>(particle_.size()); }
  const std::vector<int>& particles() const { return particle_; }  ///< by slot
  const std::vector<int>& slots() const { return slot_; }          ///< by particle

  /// Pairs of slots i < j, each once: all whose centres are closer than the range when they were sorted, nearest images
  /// counting, and some that are farther by rounding. The same order for any number of threads.
  const std::vector<Pair>& pairs(parallel::Team& team);

  /// A time (s) of flight at constant velocities.
  struct Flight {
    double time = 0;
    double within = 0;  ///< m: pairs that come closer than that are looked for
    double near = 0;    ///< m, above 0: and pairs that are closer than that at first
  };
  /// Of the particle in this slot (m/s), as of the last sort.
  void set_velocity(int slot, const Vec<d>& velocity);
  /// Those of pairs() that may come so close. The distance of two, r, is a convex function of time: it is never below
  /// r + r' time, r' its rate at first, and who stays within by that is found, besides some that don't by rounding.
  /// Velocities of all slots have been set since the sort.
  const std::vector<Pair>& pairs_that_meet(const Flight& flight, parallel::Team& team);

 private:
  /// Slots side by side, and how far away their image is that is near others.
  struct Among {
    int first = 0, last = 0;
    std::array<float, d> turned{};
  };
  /// Cells side by side along the first axis, and how far away their image is that is near another row.
  struct Row {
    int first = 0;  ///< cell
    std::array<float, d> turned{};
  };
  using Near = std::vector<Pair>;

  void lay_out(const Spheres<d>& spheres);
  int column(double x, int k) const;
  std::vector<Row> rows_beside(int y, int z) const;
  template <bool flies>
  const std::vector<Pair>& collect(parallel::Team& team);
  template <bool folded, bool flies>
  void search_row(int y, int z, Near& near) const;
  template <bool folded, bool flies>
  void search(int slot, const Among& among, Near& near) const;

  double range_ = 0, rounded_ = 0;  ///< rounded_: by which a difference of two places may be wrong
  float within_square_ = 0;
  float time_ = 0, met_within_ = 0, near_square_ = 0;  ///< of the flight, with what rounding needs
  std::array<int, 3> count_{1, 1, 1};
  bool folds_ = false;                                        ///< along some periodic axis there is one cell alone
  std::array<double, 3> low_{}, period_{}, cells_a_metre_{};  ///< period 0: not periodic
  std::vector<int> start_, cell_, particle_, slot_;
  std::vector<std::array<float, d>> inside_;    ///< by particle, from low_ on
  std::array<std::vector<float>, d> place_;     ///< the same by slot, and room for a whole vector beyond the last
  std::array<std::vector<float>, d> velocity_;  ///< as place_
  std::vector<Near> found_;                     ///< by task
  Near pairs_;
};

}  // namespace lichtenberg
