#include "solvers/periodic/convolution.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::periodic {

namespace {

template <class Real>
constexpr int wide = RowTransform<Real>::rows_at_once;

template <class Real>
constexpr std::ptrdiff_t whole_blocks(std::ptrdiff_t count) {
  return (count + wide<Real> - 1) / wide<Real> * wide<Real>;
}

/// Returns a stride of an odd number of blocks: a stride of a power of two would use few sets of the cache.
template <class Real>
constexpr std::ptrdiff_t odd_blocks(std::ptrdiff_t count) {
  return (whole_blocks<Real>(count) / wide<Real> | 1) * wide<Real>;
}

/// Loads the first `count` rows of a block, with starts `stride` numbers apart, and transposes them; missing rows are
/// 0.
template <class Real>
void load_columns(const Real* from, std::ptrdiff_t stride, int count,
                  typename RowTransform<Real>::Numbers (&columns)[wide<Real>]) {
  using Numbers = typename RowTransform<Real>::Numbers;
  for (int k = 0; k < wide<Real>; ++k) columns[k] = k < count ? lanes<wide<Real>>(from + k * stride) : Numbers{};
  transpose(columns);
}

/// Work arrays of one thread.
template <class Real>
class WorkArrays {
 public:
  using Numbers = typename RowTransform<Real>::Numbers;
  explicit WorkArrays(int length) : size_(length + wide<Real>), rows_(4 * size_) {}
  Numbers* re() { return &rows_[0].numbers; }
  Numbers* im() { return &rows_[size_].numbers; }
  Numbers* spare() { return &rows_[2 * size_].numbers; }

 private:
  struct alignas(64) Row {
    Numbers numbers;
  };
  std::size_t size_;
  std::vector<Row> rows_;
};

}  // namespace

template <class Real>
typename Convolution<Real>::Array Convolution<Real>::array(std::ptrdiff_t count) {
  auto* numbers = static_cast<Real*>(::operator new[](count * sizeof(Real), std::align_val_t{64}));
  std::fill_n(numbers, count, Real{});
  return Array(numbers);
}

template <class Real>
Convolution<Real>::Convolution(std::array<int, 3> points, int halo, std::span<const double> factor, double scale)
    : points_(points),
      halo_(halo),
      row_(odd_blocks<Real>(points[2] + halo)),
      across_(odd_blocks<Real>(points[1])),
      sheet_(odd_blocks<Real>(points[0] * across_)),
      pack_(points[2] % 2 == 0 ? 2 : 1),
      blocks_((points[1] + rows_at_once - 1) / rows_at_once),
      along_x_(points[0]),
      along_y_(points[1]),
      along_z_(points[2] / pack_),
      used_(static_cast<std::size_t>(points[0]) * blocks_),
      used_block_(blocks_) {
  const auto [nx, ny, nz] = points_;
  const int deep = nz / 2 + 1;
  const auto blocks = static_cast<int>(whole_blocks<Real>(nx) / wide<Real>);
  mesh_ = array(plane() * nx);
  modes_ = array(2 * deep * sheet_);
  factor_ = array(static_cast<std::ptrdiff_t>(deep) * blocks * ny * wide<Real>);
  constexpr int together = 8;  // Modes z of one cache line of `factor`
  for (int first = 0; first < deep; first += together)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (int z = first; z < std::min(deep, first + together); ++z)
          factor_[((static_cast<std::ptrdiff_t>(z) * blocks + x / wide<Real>)*ny + y) * wide<Real> + x % wide<Real>] =
              static_cast<Real>(scale * factor[(static_cast<std::size_t>(y) * nx + x) * deep + z]);
  for (int z = 0; z < deep; ++z) {
    cosine_.push_back(static_cast<Real>(std::cos(2 * M_PI * z / nz)));
    sine_.push_back(static_cast<Real>(std::sin(2 * M_PI * z / nz)));
  }
}

template <class Real>
void Convolution<Real>::clear(parallel::Team& team) {
  team.for_each(points_[0], [&](int x) {
    for (int y = 0; y < points_[1]; y += rows_at_once)
      if (used(x, y))
        std::fill_n(data() + x * plane() + y * row_, std::min(rows_at_once, points_[1] - y) * row_, Real{});
  });
  std::ranges::fill(used_, false);
  std::ranges::fill(used_block_, false);
}

/// Stores the modes of a block of rows along z. If pairs of real numbers were packed into complex ones, the transform
/// contains those of the even and odd points, which are separated by their symmetry.
template <class Real>
void Convolution<Real>::store_modes(int x, int y, const Numbers* re, const Numbers* im) {
  constexpr Real half = 0.5;
  const int last = points_[2] / 2;
  for (int z = 0; z <= last; ++z) {
    Numbers &to_re = lanes<wide<Real>>(modes(z, x, 0) + y), &to_im = lanes<wide<Real>>(modes(z, x, 1) + y);
    if (pack_ == 1) {
      to_re = re[z], to_im = im[z];
      continue;
    }
    const int here = z % last, there = (last - z) % last;
    const Numbers even_re = re[here] + re[there], even_im = im[here] - im[there];
    const Numbers odd_re = re[here] - re[there], odd_im = im[here] + im[there];
    const Real c = cosine_[z], s = sine_[z];
    to_re = half * (even_re + c * odd_im - s * odd_re);
    to_im = half * (even_im - c * odd_re - s * odd_im);
  }
}

/// The inverse of store_modes, times `pack_`.
template <class Real>
void Convolution<Real>::load_modes(int x, int y, Numbers* re, Numbers* im) {
  const int nz = points_[2], half = nz / 2;
  const auto mode = [&](int k, int part) -> const Numbers& { return lanes<wide<Real>>(modes(k, x, part) + y); };
  if (pack_ == 1) {
    for (int z = 0; z <= half; ++z) re[z] = mode(z, 0), im[z] = mode(z, 1);
    for (int z = half + 1; z < nz; ++z) re[z] = mode(nz - z, 0), im[z] = -mode(nz - z, 1);
    return;
  }
  for (int z = 0; z < half; ++z) {
    const Numbers even_re = mode(z, 0) + mode(half - z, 0), even_im = mode(z, 1) - mode(half - z, 1);
    const Numbers odd_re = mode(z, 0) - mode(half - z, 0), odd_im = mode(z, 1) + mode(half - z, 1);
    const Real c = cosine_[z], s = sine_[z];
    re[z] = even_re - c * odd_im - s * odd_re;
    im[z] = even_im + c * odd_re - s * odd_im;
  }
}

/// Adds the halo and transforms the rows along z of plane x. An even number of points is packed in pairs: even points
/// are real parts, odd points imaginary parts.
template <class Real>
[[gnu::noinline]] void Convolution<Real>::to_modes(int x) {
  const auto [nx, ny, nz] = points_;
  WorkArrays<Real> work(nz);
  Numbers *re = work.re(), *im = work.im();
  for (int y = 0; y < ny; y += wide<Real>) {
    if (!used(x, y)) continue;
    Real* rows = data() + x * plane() + y * row_;
    const int count = std::min(wide<Real>, ny - y);
    for (int k = 0; k < count; ++k)
      for (int z = 0; z < halo_; ++z) rows[k * row_ + z] += rows[k * row_ + nz + z];
    for (int z = 0; z < nz; z += wide<Real>) {
      Numbers columns[wide<Real>];
      load_columns(rows + z, row_, count, columns);
      if (pack_ == 2)
        for (int k = 0; k < wide<Real>; k += 2) re[(z + k) / 2] = columns[k], im[(z + k) / 2] = columns[k + 1];
      else
        for (int k = 0; k < wide<Real>; ++k) re[z + k] = columns[k], im[z + k] = Numbers{};
    }
    along_z_.apply(re, im, work.spare());
    store_modes(x, y, re, im);
  }
}

template <class Real>
[[gnu::noinline]] void Convolution<Real>::from_modes(int x) {
  const auto [nx, ny, nz] = points_;
  WorkArrays<Real> work(nz);
  Numbers *re = work.re(), *im = work.im();
  for (int y = 0; y < ny; y += wide<Real>) {
    if (!used(x, y)) continue;
    load_modes(x, y, re, im);
    along_z_.apply(im, re, work.spare());
    Real* rows = data() + x * plane() + y * row_;
    const int count = std::min(wide<Real>, ny - y);
    for (int z = 0; z < nz; z += wide<Real>) {
      Numbers columns[wide<Real>];
      if (pack_ == 2)
        for (int k = 0; k < wide<Real>; k += 2) columns[k] = re[(z + k) / 2], columns[k + 1] = im[(z + k) / 2];
      else
        for (int k = 0; k < wide<Real>; ++k) columns[k] = re[z + k];
      transpose(columns);
      for (int k = 0; k < count; ++k)
        std::copy_n(reinterpret_cast<const Real*>(&columns[k]), std::min(wide<Real>, nz - z), rows + k * row_ + z);
    }
    for (int k = 0; k < count; ++k)
      for (int z = 0; z < halo_; ++z) rows[k * row_ + nz + z] = rows[k * row_ + z];
  }
}

/// Transforms a block of the modes z along y, multiplies them by the factor, and transforms them back.
template <class Real>
void Convolution<Real>::filter_along_y(int z, int block, Numbers* re, Numbers* im, Numbers* spare) {
  const auto [nx, ny, nz] = points_;
  const auto blocks = static_cast<int>(whole_blocks<Real>(nx) / wide<Real>);
  const int x = block * wide<Real>, count = std::min(wide<Real>, nx - x);
  Numbers columns[wide<Real>];
  for (int part = 0; part < 2; ++part)
    for (int y = 0; y < ny; y += wide<Real>) {
      load_columns(modes(z, x, part) + y, across_, used_block_[y / wide<Real>] ? count : 0, columns);
      std::copy_n(columns, wide<Real>, (part == 0 ? re : im) + y);
    }
  along_y_.apply(re, im, spare);
  const Real* factor = &factor_[(static_cast<std::ptrdiff_t>(z) * blocks + block) * ny * wide<Real>];
  for (int y = 0; y < ny; ++y) {
    re[y] *= lanes<wide<Real>>(factor + y * wide<Real>);
    im[y] *= lanes<wide<Real>>(factor + y * wide<Real>);
  }
  along_y_.apply(im, re, spare);
  for (int part = 0; part < 2; ++part)
    for (int y = 0; y < ny; y += wide<Real>) {
      if (!used_block_[y / wide<Real>]) continue;
      std::copy_n((part == 0 ? re : im) + y, wide<Real>, columns);
      transpose(columns);
      for (int k = 0; k < count; ++k) lanes<wide<Real>>(modes(z, x + k, part) + y) = columns[k];
    }
}

template <class Real>
[[gnu::noinline]] void Convolution<Real>::filter(int z) {
  const auto [nx, ny, nz] = points_;
  WorkArrays<Real> work(std::max(nx, ny));
  Numbers *re = work.re(), *im = work.im(), *spare = work.spare();
  const auto transform_along_x = [&](bool back) {
    for (int y = 0; y < points_[1]; y += wide<Real>) {
      if (!used_block_[y / wide<Real>]) continue;
      const auto mode = [&](int x, int part) -> Numbers& { return lanes<wide<Real>>(modes(z, x, part) + y); };
      for (int x = 0; x < points_[0]; ++x) {
        const bool has = back || used(x, y);
        re[x] = has ? mode(x, 0) : Numbers{}, im[x] = has ? mode(x, 1) : Numbers{};
      }
      back ? along_x_.apply(im, re, spare) : along_x_.apply(re, im, spare);
      for (int x = 0; x < points_[0]; ++x)
        if (!back || used(x, y)) mode(x, 0) = re[x], mode(x, 1) = im[x];
    }
  };
  transform_along_x(false);
  for (int block = 0; block * wide<Real> < nx; ++block) filter_along_y(z, block, re, im, spare);
  transform_along_x(true);
}

template <class Real>
void Convolution<Real>::apply(parallel::Team& team) {
  team.for_each(points_[0], [&](int x) { to_modes(x); });
  team.for_each(points_[2] / 2 + 1, [&](int z) { filter(z); });
  team.for_each(points_[0], [&](int x) { from_modes(x); });
}

template class Convolution<float>;
template class Convolution<double>;

}  // namespace lichtenberg::periodic
