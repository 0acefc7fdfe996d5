#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// A position along one axis of a periodic box, in parts of 2^-32 (single precision) or 2^-64 of its length. Overflow
/// goes around the box: the difference of two, taken for a signed number, is that of the nearest images.
template <class Real>
using Coordinate = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
template <class Real>
using Difference = std::make_signed_t<Coordinate<Real>>;
/// Bits of a coordinate.
template <class Real>
constexpr int bits_of = 8 * sizeof(Real);

/// The product of a coordinate with a number of parts of the box: the part that it lies in, and the rest as a fraction.
template <class Place>
struct InParts {
  int part;
  Place rest;

  InParts(Place place, int count) {
    __extension__ using Wide = std::conditional_t<sizeof(Place) == 4, std::uint64_t, unsigned __int128>;
    const Wide product = static_cast<Wide>(place) * static_cast<Wide>(count);
    part = static_cast<int>(product >> std::numeric_limits<Place>::digits);
    rest = static_cast<Place>(product);
  }
};
template <class Place>
int part(Place place, int count) {
  return InParts<Place>(place, count).part;
}

/// Sources sorted into columns along z, each going up z bin by bin, with an array for each coordinate and component.
/// Columns make up tiles, at least twice a reach wide along x and y, so that interactions up to that reach from a
/// tile's sources involve half of each tile around it. Charges are in units of charge_unit(), dipoles in that times
/// `length_unit`.
template <class Real>
class Columns {
 public:
  using Place = Coordinate<Real>;
  struct Layout {
    double length_unit = 1;
    int together = 8;   ///< a column is about as wide as a cube with so many sources
    double widest = 0;  ///< width of a column at most
    double reach = 0;
  };
  Columns(Vec3 lengths, const Layout& layout) : lengths_(lengths), layout_(layout) {}

  /// Throws Failure if a position is not finite.
  void sort(const Sources& sources, parallel::Team& team);

  int size() const { return static_cast<int>(sorted_.size()); }
  /// Arrays of sorted sources. Behind the last there are `spare` more elements, of no meaning.
  const Place* place(int axis) const { return place_[axis].data(); }
  const Real* charge() const { return quantity_[0].data(); }
  /// The charge (0), or a component of the dipole (1 to 3), if the sources have dipoles.
  const Real* quantity(int k) const { return quantity_[k].data(); }
  /// A power of two: charges are divided by it exactly.
  double charge_unit() const { return charge_unit_; }
  double total_charge() const { return total_charge_; }  ///< over charge_unit()
  const int* sorted() const { return sorted_.data(); }   ///< where a source is, by number

  std::array<int, 2> count() const { return {tiles_[0] * columns_[0], tiles_[1] * columns_[1]}; }
  /// Columns are numbered in the order in which sources are sorted.
  int number_of(int x, int y) const { return before_[0][x] + before_[1][y]; }
  std::array<int, 2> column(int number) const {
    const int tile = number / columns_a_tile(), inside = number % columns_a_tile();
    return {tile / tiles_[1] * columns_[0] + inside / columns_[1],
            tile % tiles_[1] * columns_[1] + inside % columns_[1]};
  }
  int bins() const { return bins_; }  ///< of a column
  /// The first sorted source of each bin of a column; that of bin bins() is the column's end.
  const int* first(int column) const { return &first_[static_cast<std::size_t>(column) * bins_]; }

  /// Calls work(first, end) for the columns of each tile. Tiles of every other row and column are taken at a time, so
  /// that no two reach the same sources, and each is reached in the same order for any number of threads.
  template <class Work>
  void for_each_apart(parallel::Team& team, const Work& work) const {
    const int step_x = std::min(tiles_[0], 2), step_y = std::min(tiles_[1], 2), rows = tiles_[1] / step_y;
    for (int x = 0; x < step_x; ++x)
      for (int y = 0; y < step_y; ++y)
        team.for_each(tiles_[0] / step_x * rows, [&](int k) {
          const int tile = (x + k / rows * step_x) * tiles_[1] + y + k % rows * step_y;
          work(tile * columns_a_tile(), (tile + 1) * columns_a_tile());
        });
  }

  static constexpr int spare = 16;

 private:
  int columns_a_tile() const { return columns_[0] * columns_[1]; }
  void lay_out(int sources);
  void place_sources(const Sources& sources, int first, int last);
  void store(const Sources& sources);

  Vec3 lengths_;
  Layout layout_;
  int laid_out_for_ = -1;                   ///< number of sources
  std::array<int, 2> tiles_{}, columns_{};  ///< along x and y: one or an even number of tiles; columns of a tile
  std::array<std::vector<int>, 2> before_;  ///< columns by their place along an axis: number_of
  int bins_ = 0;
  double charge_unit_ = 1, total_charge_ = 0;
  std::vector<std::array<Place, 3>> found_;  ///< places, by number
  std::vector<int> bin_;                     ///< that a source is in, by number
  std::vector<int> first_, next_;            ///< sorted source of a bin
  std::vector<int> sorted_;
  std::array<std::vector<Place>, 3> place_;
  std::array<std::vector<Real>, 4> quantity_;
};

/// Sums for sorted sources, in units of charge_unit() and length_unit.
template <class Real>
struct FeltSums {
  std::span<Real> field;    ///< field x, y, z and potential, four numbers each
  std::span<Real> force{};  ///< x, y, z and a number without meaning; only of Kind::multipoles
};

}  // namespace lichtenberg::periodic
