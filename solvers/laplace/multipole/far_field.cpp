#include "solvers/laplace/multipole/far_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::multipole {

namespace {

/// Returns phase factors over a period of 2n cells: a phase of pi per period if the sign alternates, otherwise 1.
std::vector<Complex> phase_factors(int period, int sign) {
  std::vector<Complex> twist(period);
  for (int i = 0; i < period; ++i) twist[i] = sign > 0 ? Complex{1} : std::polar(1.0, -std::numbers::pi * i / period);
  return twist;
}

}  // namespace

FarField::FarField(const Mirrors& mirrors, const LatticeSum& lattice, const Cells& cells, int order)
    : mirrors_(mirrors),
      nx_(cells.nx),
      ny_(cells.ny),
      window_(cells.window),
      order_(order),
      columns_(2 * cells.nx),
      rows_(2 * cells.ny),
      width_(cells.width),
      height_(cells.height),
      scale_(std::max(cells.width, cells.height)),
      source_(static_cast<std::size_t>(nx_) * ny_ * (order + 1)),
      local_(source_.size()),
      twist_x_(phase_factors(columns_, mirrors.period_sign_x())),
      twist_y_(phase_factors(rows_, mirrors.period_sign_y())) {
  data_ = make_fftw_numbers(2 * grid() * (2 * order_ + 1));
  forward_ = plan(order_ + 1, FFTW_FORWARD);
  backward_ = plan(order_ + 1, FFTW_BACKWARD);
  make_kernel(lattice, cells);
}

bool FarField::fits(const Mirrors& mirrors, const Cells& cells, int order) const {
  return mirrors.bounded == mirrors_.bounded && mirrors.size == mirrors_.size &&
         mirrors.side_sign == mirrors_.side_sign && cells.nx == nx_ && cells.ny == ny_ && cells.width == width_ &&
         cells.height == height_ && cells.window == window_ && order == order_;
}

/// Plans two-dimensional in-place transforms of the first `count` planes. FFTW_MEASURE would choose by timing, so that
/// results would differ in their last bits.
FftwPlan FarField::plan(int count, int direction) {
  auto* data = reinterpret_cast<fftw_complex*>(data_.get());
  const std::array<int, 2> size{rows_, columns_};
  const int distance = static_cast<int>(grid());
  return FftwPlan(fftw_plan_many_dft(2, size.data(), count, data, nullptr, 1, distance, data, nullptr, 1, distance,
                                     direction, fftw_planning));
}

/// Computes G_0 ... G_(2 order) for two cells (di, dj) apart, less than half a period, where the lattice's Taylor
/// series is valid. Near images are excluded.
void FarField::cell_interaction(const LatticeSum& lattice, const Cells& cells, int di, int dj,
                                std::vector<Complex>& value) const {
  const int count = static_cast<int>(value.size());
  const Complex distance{di * cells.width, dj * cells.height};
  lattice.far_derivatives(distance, count, value.data());
  lattice.add_background(distance, value.data());
  double power = 1;
  for (int n = 1; n < count; ++n) value[n] *= power *= scale_;
  for (const LatticeSum::Vector& w : lattice.near()) {
    if (cells.is_near(di - columns_ * w.n, dj - rows_ * w.m)) continue;
    const Complex inverse = -scale_ / (distance - w.shift);
    value[0] += w.sign * std::log(std::abs(distance - w.shift));
    Complex term = -w.sign * inverse;  // (-1)^(n-1) (n-1)! (h / (distance - w))^n
    for (int n = 1; n < count; ++n) {
      value[n] += term;
      term = multiply(term, inverse) * static_cast<double>(n);
    }
  }
  value[0] = value[0].real();
}

/// Computes the spectra of G_n over all displacements of two cells. The lattice is symmetric in both axes: the value at
/// a displacement to the left is the conjugate of (-1)^n times that to the right, downward the conjugate of that
/// upward.
void FarField::make_kernel(const LatticeSum& lattice, const Cells& cells) {
  const int count = 2 * order_ + 1;
  std::vector<Complex> value(count);
  const auto put = [&](int di, int dj) {
    const int i = di < 0 ? di + columns_ : di, j = dj < 0 ? dj + rows_ : dj;
    double sign = 1, turn = di < 0 ? -1 : 1;
    if (di < 0) sign *= mirrors_.period_sign_x();
    if (dj < 0) sign *= mirrors_.period_sign_y();
    const bool conjugate = (di < 0) != (dj < 0);
    for (int n = 0; n < count; ++n, sign *= turn)
      plane(n)[at(i, j)] = sign * multiply(conjugate ? std::conj(value[n]) : value[n], twist(i, j));
  };
  for (int dj = 0; dj <= ny_; ++dj)
    for (int di = 0; di <= nx_; ++di) {
      cell_interaction(lattice, cells, di, dj, value);
      if (di < nx_ && dj < ny_) put(di, dj);
      if (di > 0 && dj < ny_) put(-di, dj);
      if (di < nx_ && dj > 0) put(di, -dj);
      if (di > 0 && dj > 0) put(-di, -dj);
    }
  const FftwPlan transform = plan(count, FFTW_FORWARD);
  fftw_execute(transform.get());
  const double normalization = 1.0 / static_cast<double>(grid());
  kernel_re_.resize(count * grid());
  kernel_im_.resize(count * grid());
  for (std::size_t n = 0; n < count * grid(); ++n) {
    kernel_re_[n] = normalization * plane(0)[n].real();
    kernel_im_[n] = normalization * plane(0)[n].imag();
  }
}

void FarField::clear_sources() { std::fill(source_.begin(), source_.end(), Complex{0}); }

void FarField::apply() {
  spread();
  fftw_execute(forward_.get());
  multiply_spectra();
  fftw_execute(backward_.get());
  collect();
}

/// Copies the sources and their mirror images, which together fill one period.
void FarField::spread() {
  std::fill(plane(0), plane(order_ + 1), Complex{0});
  for (const Image& image : mirrors_.images) {
    // The image at -x is stored one period further, at 2 Lx - x.
    const double shifted =
        (image.across_x ? mirrors_.period_sign_x() : 1) * (image.across_y ? mirrors_.period_sign_y() : 1);
    for (int j = 0; j < ny_; ++j)
      for (int i = 0; i < nx_; ++i) {
        const Complex* from = source(j * nx_ + i);
        const int column = image.across_x ? columns_ - 1 - i : i, row = image.across_y ? rows_ - 1 - j : j;
        const Complex factor = shifted * twist(column, row);
        Complex* to = plane(0) + at(column, row);
        for (int k = 0; k <= order_; ++k) to[k * grid()] = multiply(factor, image.coefficient(k, from[k]));
      }
  }
}

/// Computes beta_m = sum_k G_(m+k) alpha_k for each frequency, in blocks that fit into the cache.
void FarField::multiply_spectra() {
  constexpr int block = 16;
  using Block = std::array<double, block>;
  const int count = order_ + 1;
  std::vector<Block> re(count), im(count);
  for (std::size_t start = 0; start < grid(); start += block) {
    const int size = static_cast<int>(std::min<std::size_t>(block, grid() - start));
    for (int k = 0; k < count; ++k)
      for (int f = 0; f < size; ++f) {
        re[k][f] = plane(k)[start + f].real();
        im[k][f] = plane(k)[start + f].imag();
      }
    for (int m = 0; m < count; ++m) {
      Block sum_re{}, sum_im{};
      for (int k = 0; k < count; ++k) {
        const double* g_re = &kernel_re_[(m + k) * grid() + start];
        const double* g_im = &kernel_im_[(m + k) * grid() + start];
        for (int f = 0; f < size; ++f) {
          sum_re[f] += g_re[f] * re[k][f] - g_im[f] * im[k][f];
          sum_im[f] += g_re[f] * im[k][f] + g_im[f] * re[k][f];
        }
      }
      for (int f = 0; f < size; ++f) plane(m)[start + f] = {sum_re[f], sum_im[f]};
    }
  }
}

void FarField::collect() {
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
      const Complex factor = std::conj(twist(i, j));
      Complex* to = &local_[(static_cast<std::size_t>(j) * nx_ + i) * (order_ + 1)];
      for (int m = 0; m <= order_; ++m) to[m] = multiply(factor, plane(m)[at(i, j)]);
    }
}

}  // namespace lichtenberg::laplace::multipole
