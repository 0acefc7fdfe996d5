#pragma once

#include <array>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/fft.hpp"

namespace lichtenberg::periodic {

/// Periodic convolution on a mesh by FFT: stores real numbers on the mesh, and convolves them with a kernel that is
/// given by its Fourier transform. Rows along z have `halo` extra points at their end, so that charge assignment and
/// interpolation need no periodic wrap there.
template <class Real>
class Convolution {
 public:
  /// Makes a convolution on a mesh of `points` that multiplies mode (x, y, z) by `scale` times factor[(y * points[0] +
  /// x) * (points[2] / 2 + 1) + z].
  Convolution(std::array<int, 3> points, int halo, std::span<const double> factor, double scale);

  std::array<int, 3> points() const { return points_; }  ///< Numbers of mesh points along x, y, z
  /// Returns the mesh values; point (x, y, z) is at x * plane() + y * row() + z, with z below points()[2] + halo.
  Real* data() { return mesh_.get(); }
  const Real* data() const { return mesh_.get(); }
  std::ptrdiff_t row() const { return row_; }                 ///< Stride between rows along z
  std::ptrdiff_t plane() const { return row_ * points_[1]; }  ///< Stride between planes of constant x

  /// Sets all mesh values to 0, and forgets which rows are used.
  void clear(parallel::Team& team);
  /// States that row (x, y) holds values until the next clear(). Results are computed in the used rows and some around
  /// them only: a cluster in a wide box takes less time.
  void use(int x, int y) { used_[x * blocks_ + y / rows_at_once] = used_block_[y / rows_at_once] = true; }
  /// Convolves the mesh values in place. First adds the values of the halo to the points of which it is the periodic
  /// image; at the end copies the result to the halo. Forward and backward transform are not normalized. The result has
  /// identical bits for any number of threads.
  void apply(parallel::Team& team);

 private:
  using Numbers = typename RowTransform<Real>::Numbers;
  static constexpr int rows_at_once = RowTransform<Real>::rows_at_once;
  struct Free {
    void operator()(Real* p) const { ::operator delete[](p, std::align_val_t{64}); }
  };
  using Array = std::unique_ptr<Real[], Free>;
  static Array array(std::ptrdiff_t count);

  bool used(int x, int y) const { return used_[x * blocks_ + y / rows_at_once]; }
  void to_modes(int x);
  void filter(int z);
  void from_modes(int x);
  void store_modes(int x, int y, const Numbers* re, const Numbers* im);
  void load_modes(int x, int y, Numbers* re, Numbers* im);
  void filter_along_y(int z, int block, Numbers* re, Numbers* im, Numbers* spare);
  /// Real (part 0) or imaginary (1) parts of the modes z of row x.
  Real* modes(int z, int x, int part) { return modes_.get() + (2 * z + part) * sheet_ + x * across_; }

  std::array<int, 3> points_;
  int halo_;
  /// Strides: of a mesh row along z, of the modes along y, of one z plane of modes.
  std::ptrdiff_t row_, across_, sheet_;
  int pack_;    ///< Real numbers along z packed into one complex number: 2 if points[2] is even, otherwise 1
  int blocks_;  ///< Number of blocks of `rows_at_once` rows of a plane
  RowTransform<Real> along_x_, along_y_, along_z_;
  std::vector<char> used_, used_block_;  ///< Blocks with values: [x][block]; [block] for any x
  std::vector<Real> cosine_, sine_;      ///< Cosine and sine of 2 pi z / points along z
  /// Layouts: [x][y][z]; [mode z][part][x][y]; [mode z][block of x][y][x of the block].
  Array mesh_, modes_, factor_;
};

}  // namespace lichtenberg::periodic
