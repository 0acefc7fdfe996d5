#include "solvers/periodic/single_convolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::periodic {

namespace {

constexpr int wide = RowTransform::side_by_side;
using Numbers = RowTransform::Numbers;

constexpr std::ptrdiff_t whole_blocks(std::ptrdiff_t count) { return (count + wide - 1) / wide * wide; }

std::vector<int> radices_of(int length) {
  std::vector<int> radices;
  for (const int radix : {4, 5, 3, 2})
    for (; length % radix == 0; length /= radix) radices.push_back(radix);
  for (int radix = 7; length > 1; radix += 2)
    for (; length % radix == 0; length /= radix) radices.push_back(radix);
  return radices;
}

struct Complex {
  Numbers re, im;

  friend Complex operator+(const Complex& a, const Complex& b) { return {a.re + b.re, a.im + b.im}; }
  friend Complex operator-(const Complex& a, const Complex& b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(float s, const Complex& a) { return {s * a.re, s * a.im}; }
  Complex turned() const { return {im, -re}; }  ///< times -i
};

/// The transform of so many numbers.
void transform(Complex (&a)[2]) {
  const Complex sum = a[0] + a[1];
  a[1] = a[0] - a[1];
  a[0] = sum;
}
void transform(Complex (&a)[3]) {
  constexpr float half_root = 0.5f * std::numbers::sqrt3_v<float>;
  const Complex sum = a[1] + a[2], mean = a[0] - 0.5f * sum, apart = half_root * (a[1] - a[2]).turned();
  a[0] = a[0] + sum;
  a[1] = mean + apart;
  a[2] = mean - apart;
}
void transform(Complex (&a)[4]) {
  const Complex even = a[0] + a[2], odd = a[1] + a[3], apart = a[0] - a[2], turned = (a[1] - a[3]).turned();
  a[0] = even + odd;
  a[1] = apart + turned;
  a[2] = even - odd;
  a[3] = apart - turned;
}
void transform(Complex (&a)[5]) {
  constexpr float c1 = 0.30901699437494742f, c2 = -0.80901699437494742f, s1 = 0.95105651629515357f,
                  s2 = 0.58778525229247313f;
  const Complex outer = a[1] + a[4], inner = a[2] + a[3], outer_apart = a[1] - a[4], inner_apart = a[2] - a[3];
  const Complex first = a[0] + c1 * outer + c2 * inner, second = a[0] + c2 * outer + c1 * inner;
  const Complex first_turned = (s1 * outer_apart + s2 * inner_apart).turned(),
                second_turned = (s2 * outer_apart - s1 * inner_apart).turned();
  a[0] = a[0] + outer + inner;
  a[1] = first + first_turned;
  a[2] = second + second_turned;
  a[3] = second - second_turned;
  a[4] = first - first_turned;
}

/// Sixteen rows of sixteen numbers, turned into columns. Each round moves a bit of a number's row to its column and
/// one of its column to its row; after four they are exchanged.
void transpose(Numbers (&rows)[wide]) {
#pragma GCC unroll 4
  for (int round = 0; round < 4; ++round) {
    Numbers turned[wide];
#pragma GCC unroll 8
    for (int k = 0; k < 8; ++k) {
      turned[2 * k] =
          __builtin_shufflevector(rows[k], rows[k + 8], 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
      turned[2 * k + 1] =
          __builtin_shufflevector(rows[k], rows[k + 8], 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
    }
    for (int k = 0; k < wide; ++k) rows[k] = turned[k];
  }
}

/// `count` rows of sixteen that lie `apart`, as columns of sixteen with zeros behind them.
void load_columns(const float* from, std::ptrdiff_t apart, int count, Numbers (&columns)[wide]) {
  for (int k = 0; k < wide; ++k) columns[k] = k < count ? lanes<wide>(from + k * apart) : Numbers{};
  transpose(columns);
}

/// Room for a task of one thread.
struct Room {
  explicit Room(int length) : re(length + wide), im(length + wide), spare(2 * (length + wide)) {}
  struct alignas(64) Row {
    Numbers numbers;
  };
  std::vector<Row> re, im, spare;

  static Numbers* of(std::vector<Row>& rows) { return &rows.front().numbers; }
};

}  // namespace

RowTransform::RowTransform(int length) : length_(length) {
  int left = length, stride = 1;
  for (const int radix : radices_of(length)) {
    Pass pass{radix, left / radix, stride, {}, {}};
    for (int group = 0; group < pass.groups; ++group)
      for (int k = 0; k < radix; ++k) {
        const double angle = 2 * M_PI * group * k / left;
        pass.cosine.push_back(static_cast<float>(std::cos(angle)));
        pass.sine.push_back(static_cast<float>(-std::sin(angle)));
      }
    passes_.push_back(std::move(pass));
    left /= radix;
    stride *= radix;
  }
}

template <int radix>
void RowTransform::apply(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im) {
  const std::ptrdiff_t between = static_cast<std::ptrdiff_t>(pass.groups) * pass.stride;
  for (int group = 0; group < pass.groups; ++group) {
    const float *cosine = &pass.cosine[group * radix], *sine = &pass.sine[group * radix];
    for (int q = 0; q < pass.stride; ++q) {
      const std::ptrdiff_t from = group * pass.stride + q, to = group * radix * pass.stride + q;
      Complex a[radix];
      for (int k = 0; k < radix; ++k) a[k] = {re[from + k * between], im[from + k * between]};
      transform(a);
      to_re[to] = a[0].re;
      to_im[to] = a[0].im;
      for (int k = 1; k < radix; ++k) {
        to_re[to + k * pass.stride] = cosine[k] * a[k].re - sine[k] * a[k].im;
        to_im[to + k * pass.stride] = cosine[k] * a[k].im + sine[k] * a[k].re;
      }
    }
  }
}

void RowTransform::apply_any(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im) {
  const std::ptrdiff_t between = static_cast<std::ptrdiff_t>(pass.groups) * pass.stride;
  for (int group = 0; group < pass.groups; ++group)
    for (int q = 0; q < pass.stride; ++q)
      for (int k = 0; k < pass.radix; ++k) {
        Complex sum{};
        for (int j = 0; j < pass.radix; ++j) {
          const std::ptrdiff_t from = group * pass.stride + q + j * between;
          const double angle = 2 * M_PI * (j * k % pass.radix) / pass.radix;
          const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(-std::sin(angle));
          sum = sum + Complex{c * re[from] - s * im[from], c * im[from] + s * re[from]};
        }
        const float c = pass.cosine[group * pass.radix + k], s = pass.sine[group * pass.radix + k];
        const std::ptrdiff_t to = (group * pass.radix + k) * pass.stride + q;
        to_re[to] = c * sum.re - s * sum.im;
        to_im[to] = c * sum.im + s * sum.re;
      }
}

void RowTransform::apply(Numbers* re, Numbers* im, Numbers* spare) const {
  Numbers *from_re = re, *from_im = im, *to_re = spare, *to_im = spare + length_;
  for (const Pass& pass : passes_) {
    switch (pass.radix) {
      case 2:
        apply<2>(pass, from_re, from_im, to_re, to_im);
        break;
      case 3:
        apply<3>(pass, from_re, from_im, to_re, to_im);
        break;
      case 4:
        apply<4>(pass, from_re, from_im, to_re, to_im);
        break;
      case 5:
        apply<5>(pass, from_re, from_im, to_re, to_im);
        break;
      default:
        apply_any(pass, from_re, from_im, to_re, to_im);
    }
    std::swap(from_re, to_re);
    std::swap(from_im, to_im);
  }
  if (from_re == re) return;
  std::copy_n(from_re, length_, re);
  std::copy_n(from_im, length_, im);
}

SingleConvolution::Array SingleConvolution::array(std::ptrdiff_t count) {
  auto* numbers = static_cast<float*>(::operator new[](count * sizeof(float), std::align_val_t{64}));
  std::fill_n(numbers, count, 0.0f);
  return Array(numbers);
}

SingleConvolution::SingleConvolution(std::array<int, 3> points, int halo, std::span<const double> factor, double scale)
    : points_(points),
      halo_(halo),
      row_(whole_blocks(points[2] + halo)),
      across_(whole_blocks(points[1])),
      along_x_(points[0]),
      along_y_(points[1]),
      half_z_(points[2] / 2) {
  const auto [nx, ny, nz] = points_;
  const int deep = nz / 2 + 1;
  const auto blocks = static_cast<int>(whole_blocks(nx) / wide);
  mesh_ = array(plane() * nx);
  modes_ = array(static_cast<std::ptrdiff_t>(2) * deep * nx * across_);
  factor_ = array(static_cast<std::ptrdiff_t>(deep) * blocks * ny * wide);
  for (int z = 0; z < deep; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        factor_[((static_cast<std::ptrdiff_t>(z) * blocks + x / wide) * ny + y) * wide + x % wide] =
            static_cast<float>(scale * factor[(static_cast<std::size_t>(y) * nx + x) * deep + z]);
  for (int z = 0; z < deep; ++z) {
    cosine_.push_back(static_cast<float>(std::cos(2 * M_PI * z / nz)));
    sine_.push_back(static_cast<float>(std::sin(2 * M_PI * z / nz)));
  }
}

void SingleConvolution::clear(parallel::Team& team) {
  team.for_each(points_[0], [&](int x) { std::fill_n(data() + x * plane(), plane(), 0.0f); });
}

/// Rows along z, of one x: even places are taken for real parts and odd ones for imaginary parts of half as many
/// numbers, whose transform is then taken apart.
[[gnu::noinline]] void SingleConvolution::to_modes(int x) {
  const auto [nx, ny, nz] = points_;
  const int half = nz / 2;
  Room room(nz);
  Numbers *re = Room::of(room.re), *im = Room::of(room.im), *spare = Room::of(room.spare);
  for (int y = 0; y < ny; y += wide) {
    float* rows = data() + x * plane() + y * row_;
    for (int k = 0; k < std::min(wide, ny - y); ++k)
      for (int z = 0; z < halo_; ++z) rows[k * row_ + z] += rows[k * row_ + nz + z];
    for (int z = 0; z < nz; z += wide) {
      Numbers columns[wide];
      load_columns(rows + z, row_, std::min(wide, ny - y), columns);
      for (int k = 0; k < wide; k += 2) re[(z + k) / 2] = columns[k], im[(z + k) / 2] = columns[k + 1];
    }
    half_z_.apply(re, im, spare);
    for (int z = 0; z <= half; ++z) {
      const int here = z % half, there = (half - z) % half;
      const Numbers even_re = re[here] + re[there], even_im = im[here] - im[there];
      const Numbers odd_re = re[here] - re[there], odd_im = im[here] + im[there];
      const float c = cosine_[z], s = sine_[z];
      lanes<wide>(modes(z, x, 0) + y) = 0.5f * (even_re + c * odd_im - s * odd_re);
      lanes<wide>(modes(z, x, 1) + y) = 0.5f * (even_im - c * odd_re - s * odd_im);
    }
  }
}

[[gnu::noinline]] void SingleConvolution::from_modes(int x) {
  const auto [nx, ny, nz] = points_;
  const int half = nz / 2;
  Room room(nz);
  Numbers *re = Room::of(room.re), *im = Room::of(room.im), *spare = Room::of(room.spare);
  for (int y = 0; y < ny; y += wide) {
    for (int z = 0; z < half; ++z) {
      const auto mode = [&](int k, int part) -> const Numbers& { return lanes<wide>(modes(k, x, part) + y); };
      const Numbers even_re = mode(z, 0) + mode(half - z, 0), even_im = mode(z, 1) - mode(half - z, 1);
      const Numbers odd_re = mode(z, 0) - mode(half - z, 0), odd_im = mode(z, 1) + mode(half - z, 1);
      const float c = cosine_[z], s = sine_[z];
      re[z] = even_re - c * odd_im - s * odd_re;
      im[z] = even_im + c * odd_re - s * odd_im;
    }
    half_z_.apply(im, re, spare);
    float* rows = data() + x * plane() + y * row_;
    const int count = std::min(wide, ny - y);
    for (int z = 0; z < nz; z += wide) {
      Numbers columns[wide];
      for (int k = 0; k < wide; k += 2) columns[k] = re[(z + k) / 2], columns[k + 1] = im[(z + k) / 2];
      transpose(columns);
      for (int k = 0; k < count; ++k)
        std::copy_n(reinterpret_cast<const float*>(&columns[k]), std::min(wide, nz - z), rows + k * row_ + z);
    }
    for (int k = 0; k < count; ++k)
      for (int z = 0; z < halo_; ++z) rows[k * row_ + nz + z] = rows[k * row_ + z];
  }
}

/// Modes of one z: along x, along y, times the factor, and back.
[[gnu::noinline]] void SingleConvolution::filter(int z) {
  const auto [nx, ny, nz] = points_;
  Room room(std::max(nx, ny));
  Numbers *re = Room::of(room.re), *im = Room::of(room.im), *spare = Room::of(room.spare);
  const auto transform_along_x = [&](bool back) {
    for (int y = 0; y < ny; y += wide) {
      for (int x = 0; x < nx; ++x) re[x] = lanes<wide>(modes(z, x, 0) + y), im[x] = lanes<wide>(modes(z, x, 1) + y);
      back ? along_x_.apply(im, re, spare) : along_x_.apply(re, im, spare);
      for (int x = 0; x < nx; ++x) lanes<wide>(modes(z, x, 0) + y) = re[x], lanes<wide>(modes(z, x, 1) + y) = im[x];
    }
  };
  transform_along_x(false);
  const auto blocks = static_cast<int>(whole_blocks(nx) / wide);
  for (int block = 0; block < blocks; ++block) {
    const int x = block * wide, count = std::min(wide, nx - x);
    for (int part = 0; part < 2; ++part)
      for (int y = 0; y < ny; y += wide) {
        Numbers columns[wide];
        load_columns(modes(z, x, part) + y, across_, count, columns);
        std::copy_n(columns, wide, (part == 0 ? re : im) + y);
      }
    along_y_.apply(re, im, spare);
    const float* factor = &factor_[(static_cast<std::ptrdiff_t>(z) * blocks + block) * ny * wide];
    for (int y = 0; y < ny; ++y) {
      re[y] *= lanes<wide>(factor + y * wide);
      im[y] *= lanes<wide>(factor + y * wide);
    }
    along_y_.apply(im, re, spare);
    for (int part = 0; part < 2; ++part)
      for (int y = 0; y < ny; y += wide) {
        Numbers columns[wide];
        std::copy_n((part == 0 ? re : im) + y, wide, columns);
        transpose(columns);
        for (int k = 0; k < count; ++k) lanes<wide>(modes(z, x + k, part) + y) = columns[k];
      }
  }
  transform_along_x(true);
}

void SingleConvolution::apply(parallel::Team& team) {
  team.for_each(points_[0], [&](int x) { to_modes(x); });
  team.for_each(points_[2] / 2 + 1, [&](int z) { filter(z); });
  team.for_each(points_[0], [&](int x) { from_modes(x); });
}

}  // namespace lichtenberg::periodic
