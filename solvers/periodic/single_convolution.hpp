#pragma once

#include <array>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "solvers/periodic/lanes.hpp"

namespace lichtenberg::periodic {

/// A discrete Fourier transform of complex numbers along one axis, of `side_by_side` rows at once (Stockham's method,
/// radices 2 to 5, and any other prime's by its definition). FFTW's estimated plans for single precision take two to
/// five times as long, and measured ones would not give the same bits in each run.
class RowTransform {
 public:
  static constexpr int side_by_side = 16;
  using Numbers = Lanes<side_by_side, float>;

  explicit RowTransform(int length);

  /// Of re + i im, with exp(-2 pi i k x / length), into the same arrays; `spare`: twice the length. With re and im
  /// exchanged it is the transform back. Not normalized.
  void apply(Numbers* re, Numbers* im, Numbers* spare) const;

 private:
  struct Pass {
    int radix, groups, stride;
    std::vector<float> cosine, sine;  ///< of the twiddle factors, [groups][radix]
  };
  template <int radix>
  static void apply(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);
  static void apply_any(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im);

  int length_;
  std::vector<Pass> passes_;
};

/// What Convolution does, in single precision and with a factor that is given once.
class SingleConvolution {
 public:
  /// `factor`: as for Convolution::apply, and multiplied by `scale`. The points along z must be of an even number.
  SingleConvolution(std::array<int, 3> points, int halo, std::span<const double> factor, double scale);

  std::array<int, 3> points() const { return points_; }
  /// Point (x, y, z) is at x * plane() + y * row() + z, with z below points()[2] + halo.
  float* data() { return mesh_.get(); }
  const float* data() const { return mesh_.get(); }
  std::ptrdiff_t row() const { return row_; }
  std::ptrdiff_t plane() const { return row_ * points_[1]; }

  void clear(parallel::Team& team);
  void apply(parallel::Team& team);

 private:
  using Numbers = RowTransform::Numbers;
  struct Free {
    void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
  };
  using Array = std::unique_ptr<float[], Free>;
  static Array array(std::ptrdiff_t count);

  void to_modes(int x);
  void filter(int z);
  void from_modes(int x);
  /// Real or imaginary parts of the modes z, of row x.
  float* modes(int z, int x, int part) { return modes_.get() + ((2 * z + part) * points_[0] + x) * across_; }

  std::array<int, 3> points_;
  int halo_;
  std::ptrdiff_t row_, across_;  ///< numbers in a row of the mesh along z, of the modes along y
  RowTransform along_x_, along_y_, half_z_;
  std::vector<float> cosine_, sine_;  ///< of 2 pi z / points along z
  Array mesh_, modes_, factor_;       ///< [x][y][z]; [mode z][part][x][y]; [mode z][block of x][y][x of the block]
};

}  // namespace lichtenberg::periodic
