#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/sources.hpp"
#include "solvers/periodic/tiles.hpp"

namespace lichtenberg::periodic {

/// A place along one axis of a periodic box in parts of 2^-32 of its length. What overflows has gone around the box:
/// the difference of two, taken for a signed number, is that of the nearest images.
using Turns = std::uint32_t;

inline std::int32_t nearest_image(Turns a, Turns b) { return static_cast<std::int32_t>(a - b); }
/// Which of `count` equal parts of the box a place is in.
inline int part(Turns place, int count) { return static_cast<int>(static_cast<std::uint64_t>(place) * count >> 32); }

/// Charges sorted into columns along z, each going up z bin by bin, in single precision: an array for each coordinate,
/// so that many are computed with at a time. Columns make up tiles, at least twice a reach wide, as those of Tiles.
class Columns {
 public:
  /// Columns are at most `widest` wide, and about as wide as a cube with `together` of the charges.
  Columns(Vec3 lengths, int charges, int together, double widest, double reach);

  void sort(const Sources& sources, parallel::Team& team);

  int size() const { return static_cast<int>(sorted_.size()); }
  /// Of sorted charges. Behind the last there are `spare` more, of no meaning.
  const Turns* place(int axis) const { return place_[axis].data(); }
  const float* charge() const { return charge_.data(); }  ///< over charge_unit()
  /// A power of two: charges are divided by it exactly.
  double charge_unit() const { return charge_unit_; }
  double total_charge() const { return total_charge_; }  ///< over charge_unit()
  const int* sorted() const { return sorted_.data(); }   ///< where a charge is, by number

  std::array<int, 2> count() const { return {tiles_[0] * columns_[0], tiles_[1] * columns_[1]}; }
  /// Columns are numbered in the order in which charges are sorted.
  int number_of(int x, int y) const { return before_[0][x] + before_[1][y]; }
  std::array<int, 2> column(int number) const {
    const int tile = number / columns_a_tile(), inside = number % columns_a_tile();
    return {tile / tiles_[1] * columns_[0] + inside / columns_[1],
            tile % tiles_[1] * columns_[1] + inside % columns_[1]};
  }
  int bins() const { return bins_; }  ///< of a column
  /// The first sorted charge of each bin of a column; that of bin bins() is the column's end.
  const int* first(int column) const { return &first_[static_cast<std::size_t>(column) * bins_]; }

  /// Calls work(first, end) for the columns of each tile; what reaches no farther than half of a tile's width from them
  /// is no other tile's at that time, and is reached in the same order for any number of threads.
  template <class Work>
  void for_each_apart(parallel::Team& team, const Work& work) const {
    for_each_tile_apart(tiles_[0], tiles_[1], team,
                        [&](int tile) { work(tile * columns_a_tile(), (tile + 1) * columns_a_tile()); });
  }

  static constexpr int spare = 16;

 private:
  int columns_a_tile() const { return columns_[0] * columns_[1]; }
  void place_charges(const Sources& sources, int first, int last);

  Vec3 lengths_;
  std::array<int, 2> tiles_, columns_;      ///< along x and y: one or an even number of tiles; columns of a tile
  std::array<std::vector<int>, 2> before_;  ///< columns by their place along an axis: number_of
  int bins_;
  double charge_unit_ = 1, total_charge_ = 0;
  std::vector<std::array<Turns, 3>> found_;  ///< places, by number
  std::vector<int> bin_;                     ///< that a charge is in, by number
  std::vector<int> first_, next_;            ///< sorted charge of a bin
  std::vector<int> sorted_;
  std::array<std::vector<Turns>, 3> place_;
  std::vector<float> charge_;
};

}  // namespace lichtenberg::periodic
