#include "solvers/periodic/fft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::periodic {

namespace {

std::vector<int> radices_of(int length) {
  std::vector<int> radices;
  for (const int radix : {4, 5, 3, 2})
    for (; length % radix == 0; length /= radix) radices.push_back(radix);
  for (int radix = 7; length > 1; radix += 2)
    for (; length % radix == 0; length /= radix) radices.push_back(radix);
  return radices;
}

template <class Real>
struct Complex {
  using Numbers = typename RowTransform<Real>::Numbers;
  Numbers re, im;

  friend Complex operator+(const Complex& a, const Complex& b) { return {a.re + b.re, a.im + b.im}; }
  friend Complex operator-(const Complex& a, const Complex& b) { return {a.re - b.re, a.im - b.im}; }
  friend Complex operator*(Real s, const Complex& a) { return {s * a.re, s * a.im}; }
  Complex times_minus_i() const { return {im, -re}; }  ///< Product with -i
};

template <class Real>
void transform(Complex<Real> (&a)[2]) {
  const Complex sum = a[0] + a[1];
  a[1] = a[0] - a[1];
  a[0] = sum;
}
template <class Real>
void transform(Complex<Real> (&a)[3]) {
  constexpr Real half = 0.5, half_root = half * std::numbers::sqrt3_v<Real>;
  const Complex sum = a[1] + a[2], mean = a[0] - half * sum, difference = half_root * (a[1] - a[2]).times_minus_i();
  a[0] = a[0] + sum;
  a[1] = mean + difference;
  a[2] = mean - difference;
}
template <class Real>
void transform(Complex<Real> (&a)[4]) {
  const Complex even = a[0] + a[2], odd = a[1] + a[3], difference = a[0] - a[2],
                rotated = (a[1] - a[3]).times_minus_i();
  a[0] = even + odd;
  a[1] = difference + rotated;
  a[2] = even - odd;
  a[3] = difference - rotated;
}
template <class Real>
void transform(Complex<Real> (&a)[5]) {
  constexpr auto c1 = static_cast<Real>(0.30901699437494742), c2 = static_cast<Real>(-0.80901699437494742),
                 s1 = static_cast<Real>(0.95105651629515357), s2 = static_cast<Real>(0.58778525229247313);
  const Complex outer = a[1] + a[4], inner = a[2] + a[3], outer_difference = a[1] - a[4],
                inner_difference = a[2] - a[3];
  const Complex first = a[0] + c1 * outer + c2 * inner, second = a[0] + c2 * outer + c1 * inner;
  const Complex first_rotated = (s1 * outer_difference + s2 * inner_difference).times_minus_i(),
                second_rotated = (s2 * outer_difference - s1 * inner_difference).times_minus_i();
  a[0] = a[0] + outer + inner;
  a[1] = first + first_rotated;
  a[2] = second + second_rotated;
  a[3] = second - second_rotated;
  a[4] = first - first_rotated;
}

/// Appends exp(-i angle).
template <class Real>
void append(double angle, std::vector<Real>& cosine, std::vector<Real>& sine) {
  cosine.push_back(static_cast<Real>(std::cos(angle)));
  sine.push_back(static_cast<Real>(-std::sin(angle)));
}

}  // namespace

template <class Real>
RowTransform<Real>::RowTransform(int length) : length_(length) {
  int left = length, stride = 1;
  for (const int radix : radices_of(length)) {
    Pass pass{radix, left / radix, stride, {}, {}, {}, {}};
    for (int group = 0; group < pass.groups; ++group)
      for (int k = 0; k < radix; ++k) append(2 * M_PI * group * k / left, pass.cosine, pass.sine);
    for (int k = 0; k < radix && radix > 5; ++k) append(2 * M_PI * k / radix, pass.root_cosine, pass.root_sine);
    passes_.push_back(std::move(pass));
    left /= radix;
    stride *= radix;
  }
}

template <class Real>
template <int radix>
void RowTransform<Real>::apply(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re, Numbers* to_im) {
  const std::ptrdiff_t radix_stride = static_cast<std::ptrdiff_t>(pass.groups) * pass.stride;
  for (int group = 0; group < pass.groups; ++group) {
    const Real *cosine = &pass.cosine[group * radix], *sine = &pass.sine[group * radix];
    for (int q = 0; q < pass.stride; ++q) {
      const std::ptrdiff_t from = group * pass.stride + q, to = group * radix * pass.stride + q;
      Complex<Real> a[radix];
      for (int k = 0; k < radix; ++k) a[k] = {re[from + k * radix_stride], im[from + k * radix_stride]};
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

template <class Real>
void RowTransform<Real>::apply_any(const Pass& pass, const Numbers* re, const Numbers* im, Numbers* to_re,
                                   Numbers* to_im) {
  const std::ptrdiff_t radix_stride = static_cast<std::ptrdiff_t>(pass.groups) * pass.stride;
  for (int group = 0; group < pass.groups; ++group)
    for (int q = 0; q < pass.stride; ++q)
      for (int k = 0; k < pass.radix; ++k) {
        Complex<Real> sum{};
        for (int j = 0; j < pass.radix; ++j) {
          const std::ptrdiff_t from = group * pass.stride + q + j * radix_stride;
          const Real c = pass.root_cosine[j * k % pass.radix], s = pass.root_sine[j * k % pass.radix];
          sum = sum + Complex<Real>{c * re[from] - s * im[from], c * im[from] + s * re[from]};
        }
        const Real c = pass.cosine[group * pass.radix + k], s = pass.sine[group * pass.radix + k];
        const std::ptrdiff_t to = (group * pass.radix + k) * pass.stride + q;
        to_re[to] = c * sum.re - s * sum.im;
        to_im[to] = c * sum.im + s * sum.re;
      }
}

template <class Real>
void RowTransform<Real>::apply(Numbers* re, Numbers* im, Numbers* spare) const {
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

template class RowTransform<float>;
template class RowTransform<double>;

}  // namespace lichtenberg::periodic
