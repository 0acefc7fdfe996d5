#pragma once

#include <array>
#include <vector>

#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg {

/// Cell-sorted order of particles with a pair search (cell list): it stores the particles of a cell next to each other
/// in memory, in ascending order. A slot is an index in this order. Meant for callers that keep their arrays in this
/// order and rebuild the pair list every few steps; pairs.hpp is for long-lived lists.
template <int d>
class CellOrder {
 public:
  /// Sorts particles into cells at least `range` (m) wide; a periodic axis shorter than 3 `range` has a single cell.
  /// pairs() then finds all pairs with a distance of centres below `range`.
  void sort(const Spheres<d>& spheres, double range);

  /// Returns the number of particles.
  int size() const { return static_cast<int>(particle_.size()); }
  const std::vector<int>& particles() const { return particle_; }  ///< Particle of each slot
  const std::vector<int>& slots() const { return slot_; }          ///< Slot of each particle

  /// Finds all pairs of slots i < j, each once, whose centres (nearest images) are within the range of the last sort().
  /// Rounding can add pairs slightly beyond it. The order of pairs is the same for any number of threads. The reference
  /// is valid until the next search.
  const std::vector<Pair>& pairs(parallel::Team& team);

  /// Criterion of pairs_that_meet(): duration of a flight at constant velocities, and limits of distances between
  /// centres.
  struct Flight {
    double time = 0;    ///< Duration (s)
    double within = 0;  ///< Distance (m) below which a pair must be able to come during the flight
    double near = 0;    ///< Initial distance (m), above 0, below which a pair is found in any case
  };
  /// Sets the velocity (m/s) of the particle in this slot for pairs_that_meet(). The next sort() invalidates it.
  void set_velocity(int slot, const Vec<d>& velocity) {
    for (int k = 0; k < d; ++k) velocity_[k][slot] = static_cast<float>(velocity[k]);
  }
  /// Finds the pairs of pairs() that can approach to flight.within during a flight at constant velocities, or that are
  /// initially closer than flight.near. With initial distance r and its rate r', a pair is returned if r < flight.near
  /// or r + r' flight.time < flight.within, up to rounding. For approaching particles r + r' flight.time is a lower
  /// bound, because the distance is a convex function of time. The velocities of all slots must have been set since the
  /// last sort().
  const std::vector<Pair>& pairs_that_meet(const Flight& flight, parallel::Team& team);

 private:
  /// Range of slots (first ... last - 1), and the translation (m) to the periodic image that is compared.
  struct SlotRange {
    int first = 0, last = 0;
    std::array<float, d> image_shift{};
  };
  /// Row of cells along the first axis, and the translation (m) to its periodic image near another row.
  struct Row {
    int first = 0;  ///< First cell
    std::array<float, d> image_shift{};
  };
  using Near = std::vector<Pair>;

  void lay_out(const Spheres<d>& spheres);
  int column(double x, int k) const;
  std::vector<Row> neighbour_rows(int y, int z) const;
  template <bool moving>
  const std::vector<Pair>& collect(parallel::Team& team);
  template <bool nearest_images, bool moving>
  void search_row(int y, int z, Near& near) const;
  template <bool nearest_images, bool moving>
  void search(int slot, const SlotRange& candidates, Near& near) const;

  double range_ = 0, position_error_ = 0;  ///< Range, and bound on rounding errors of position differences (m)
  float within_square_ = 0;
  float time_ = 0, meeting_distance_ = 0, near_square_ = 0;  ///< Parameters of the flight, enlarged by rounding
  std::array<int, 3> count_{1, 1, 1};
  bool needs_nearest_images_ = false;  ///< True if a periodic axis has a single cell
  /// Along each axis: lower end (m), period (m; 0: not periodic), number of cells per metre.
  std::array<double, 3> low_{}, period_{}, cells_a_metre_{};
  std::vector<int> start_, cell_, particle_, slot_;
  std::vector<std::array<float, d>> wrapped_position_;  ///< Position of each particle relative to low_
  std::array<std::vector<float>, d> position_;          ///< Position of each slot, padded by a whole vector
  std::array<std::vector<float>, d> velocity_;          ///< Velocity of each slot, padded like position_
  std::vector<Near> found_;                             ///< Pairs of each task
  Near pairs_;
};

}  // namespace lichtenberg
