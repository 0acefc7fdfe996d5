#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/sources.hpp"

namespace lichtenberg::periodic {

/// Fixed-point coordinate in a periodic box: a fraction of the box length in units of 2^-32 (single precision) or 2^-64
/// (double precision). Integer overflow wraps around the box, so the signed difference of two coordinates is that of
/// the nearest images.
template <class Real>
using Coordinate = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
/// Signed difference of two fixed-point coordinates (minimum image).
template <class Real>
using Difference = std::make_signed_t<Coordinate<Real>>;
/// Number of bits of a coordinate.
template <class Real>
constexpr int bits_of = 8 * sizeof(Real);

/// Position of a fixed-point coordinate in a box that is divided into `count` equal parts. It consists of the index of
/// the part that contains the coordinate, and the position within the part as a fixed-point fraction.
template <class FixedPoint>
struct InParts {
  int part;
  FixedPoint rest;

  InParts(FixedPoint coordinate, int count) {
    __extension__ using Wide = std::conditional_t<sizeof(FixedPoint) == 4, std::uint64_t, unsigned __int128>;
    const Wide product = static_cast<Wide>(coordinate) * static_cast<Wide>(count);
    part = static_cast<int>(product >> std::numeric_limits<FixedPoint>::digits);
    rest = static_cast<FixedPoint>(product);
  }
};
/// Returns the index of the part that contains a coordinate, for `count` equal parts of the box.
template <class FixedPoint>
int part(FixedPoint coordinate, int count) {
  return InParts<FixedPoint>(coordinate, count).part;
}

/// Cell list of charges and dipoles for SIMD: sources sorted into columns along z, and by bins of z within a column,
/// with one array for each coordinate and component.
/// Columns form tiles at least twice `reach` wide along x and y, or a single tile along a short axis. Threads can thus
/// process every other tile without conflicts. Interactions of a tile's sources within `reach` involve at most half of
/// each neighbouring tile. Charges are in units of charge_unit(), dipoles in charge_unit() times `length_unit`.
template <class Real>
class Columns {
 public:
  using FixedPoint = Coordinate<Real>;
  /// Parameters of the columns: lengths, except `together`.
  struct Layout {
    double length_unit = 1;  ///< Unit of length of dipoles
    int together = 8;        ///< Number of sources in a cube of the column width, approximately
    double widest = 0;       ///< Upper bound of the column width
    double reach = 0;        ///< Distance of interactions along x and y
    /// Volume that contains the sources, at the density around a source; 0: the whole box. Only columns with sources
    /// have bins, so that a small volume in a large box costs little.
    double volume = 0;
  };
  /// Makes columns for a periodic box with these edges.
  Columns(Vec3 lengths, const Layout& layout) : lengths_(lengths), layout_(layout) {}

  /// Sorts the sources into the columns. Throws Failure if a position is not finite.
  void sort(const Sources& sources, parallel::Team& team);

  int size() const { return static_cast<int>(sorted_.size()); }  ///< Number of sources
  /// Returns the coordinates of the sorted sources along an axis. This array, and those of charge() and quantity(), are
  /// padded by `spare` elements of undefined value.
  const FixedPoint* coordinate(int axis) const { return coordinate_[axis].data(); }
  const Real* charge() const { return quantity_[0].data(); }  ///< Charges of the sorted sources
  /// Returns the charges (k = 0), or components k = 1 to 3 of the dipoles, of the sorted sources.
  const Real* quantity(int k) const { return quantity_[k].data(); }
  /// Returns the unit of charge: a power of two, so that the division of charges is exact.
  double charge_unit() const { return charge_unit_; }
  double total_charge() const { return total_charge_; }  ///< In units of charge_unit()
  const int* sorted() const { return sorted_.data(); }   ///< Sorted index of each source

  /// Returns the numbers of columns along x and y.
  std::array<int, 2> count() const { return {tiles_[0] * columns_[0], tiles_[1] * columns_[1]}; }
  /// Returns the number of column (x, y); columns are numbered in the order of the sorted sources.
  int number_of(int x, int y) const { return before_[0][x] + before_[1][y]; }
  /// Returns the indices (x, y) of the column with this number.
  std::array<int, 2> column(int number) const {
    const int tile = number / columns_a_tile(), inside = number % columns_a_tile();
    return {tile / tiles_[1] * columns_[0] + inside / columns_[1],
            tile % tiles_[1] * columns_[1] + inside % columns_[1]};
  }
  int bins() const { return bins_; }  ///< Number of bins of a column
  /// Returns the index of the first sorted source of a column, or the number of sources for the number of columns.
  int begin(int column) const { return begin_[column]; }
  /// Returns the index of the first sorted source of each bin of a column; entry bins() is the end of the column. The
  /// entries are 0 for a column without sources.
  const int* first(int column) const {
    return begin_[column] < begin_[column + 1] ? &first_[static_cast<std::size_t>(row_[column]) * bins_] : none_.data();
  }

  /// Parallel loop over tiles: calls work(first, end) with the range of columns of each tile. Only tiles of every other
  /// row and column run at the same time. If `work` writes only to sources within `reach` of its tile, no two of them
  /// write to the same source. The order of contributions to a source does not depend on the number of threads.
  template <class Work>
  void for_each_tile(parallel::Team& team, const Work& work) const {
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
  void find_coordinates(const Sources& sources, int first, int last);
  void count_sources();
  void store(const Sources& sources);

  Vec3 lengths_;
  Layout layout_;
  int laid_out_for_ = -1;                   ///< Number of sources of the present layout
  std::array<int, 2> tiles_{}, columns_{};  ///< Along x and y: number of tiles (one or even); columns of a tile
  std::array<std::vector<int>, 2> before_;  ///< Contribution of a column's index along an axis to its number: number_of
  int bins_ = 0;
  double charge_unit_ = 1, total_charge_ = 0;
  std::vector<std::array<FixedPoint, 3>> unsorted_;  ///< Positions of the sources, in input order
  std::vector<int> column_, bin_;                    ///< Column and bin of each source, in input order
  std::vector<int> begin_;                           ///< Index of the first sorted source of a column
  std::vector<int> row_;                             ///< Number of a column among those with sources
  std::vector<int> first_, next_;                    ///< Index of the first, and of the next, sorted source of a bin
  std::vector<int> none_;                            ///< Bins of a column without sources
  std::vector<int> sorted_;
  std::array<std::vector<FixedPoint>, 3> coordinate_;
  std::array<std::vector<Real>, 4> quantity_;
};

/// Results for sorted sources, to which the parts of a sum add, in units of Columns::charge_unit() and
/// Layout::length_unit.
template <class Real>
struct FieldSums {
  std::span<Real> field;    ///< Field x, y, z and potential: four numbers each
  std::span<Real> force{};  ///< Force x, y, z and an unused number; only for Kind::multipoles
};

}  // namespace lichtenberg::periodic
