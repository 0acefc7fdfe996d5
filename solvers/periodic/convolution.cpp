#include "solvers/periodic/convolution.hpp"

#include <algorithm>

namespace lichtenberg::periodic {

namespace {

// In numbers of 8 bytes: planes and sheets begin where vectors of 64 may, so that one plan serves them all.
constexpr std::ptrdiff_t whole_vectors(std::ptrdiff_t numbers) { return (numbers + 7) / 8 * 8; }

// Plans by estimate: by measurement they, and with them the bits, would change from run to run.
constexpr unsigned plan_flags = FFTW_ESTIMATE;

}  // namespace

Convolution::Convolution(std::array<int, 3> points, int halo)
    : points_(points),
      halo_(halo),
      row_(whole_vectors(points[2] + halo)),
      column_(whole_vectors(2 * (points[2] / 2 + 1)) / 2) {
  const auto [nx, ny, nz] = points_;
  mesh_ = make_fftw_numbers(plane() * nx);
  modes_ = make_fftw_numbers(2 * column_ * nx * ny);
  const std::array plane_points{ny, nz}, rows{ny, static_cast<int>(row_)}, columns{ny, static_cast<int>(row_ / 2)};
  auto* transformed = reinterpret_cast<fftw_complex*>(data());
  forward_.reset(fftw_plan_many_dft_r2c(2, plane_points.data(), 1, data(), rows.data(), 1, 0, transformed,
                                        columns.data(), 1, 0, plan_flags));
  backward_.reset(fftw_plan_many_dft_c2r(2, plane_points.data(), 1, transformed, columns.data(), 1, 0, data(),
                                         rows.data(), 1, 0, plan_flags));
  const auto sheet = [&](int direction) {
    return FftwPlan(fftw_plan_many_dft(1, &points_[0], nz / 2 + 1, modes(0, 0), nullptr, static_cast<int>(column_), 1,
                                       modes(0, 0), nullptr, static_cast<int>(column_), 1, direction, plan_flags));
  };
  sheet_forward_ = sheet(FFTW_FORWARD);
  sheet_backward_ = sheet(FFTW_BACKWARD);
}

void Convolution::clear(parallel::Team& team) {
  team.for_each(points_[0], [&](int x) { std::fill_n(data() + x * plane(), plane(), 0.0); });
}

void Convolution::fold(int x) {
  for (int y = 0; y < points_[1]; ++y) {
    double* row = data() + x * plane() + y * row_;
    for (int z = 0; z < halo_; ++z) row[z] += row[points_[2] + z];
  }
}

void Convolution::unfold(int x) {
  for (int y = 0; y < points_[1]; ++y) {
    double* row = data() + x * plane() + y * row_;
    for (int z = 0; z < halo_; ++z) row[points_[2] + z] = row[z];
  }
}

void Convolution::filter(int y, std::span<const double> factor) {
  const int deep = points_[2] / 2 + 1;
  fftw_execute_dft(sheet_forward_.get(), modes(0, y), modes(0, y));
  for (int x = 0; x < points_[0]; ++x) {
    fftw_complex* mode = modes(x, y);
    const double* by = factor.data() + (static_cast<std::ptrdiff_t>(y) * points_[0] + x) * deep;
    for (int z = 0; z < deep; ++z) mode[z][0] *= by[z], mode[z][1] *= by[z];
  }
  fftw_execute_dft(sheet_backward_.get(), modes(0, y), modes(0, y));
}

void Convolution::apply(std::span<const double> factor, parallel::Team& team) {
  const std::ptrdiff_t deep = 2 * (points_[2] / 2 + 1);  // numbers in a transformed row
  const auto row = [&](int x, int y) { return data() + x * plane() + y * row_; };
  team.for_each(points_[0], [&](int x) {
    fold(x);
    fftw_execute_dft_r2c(forward_.get(), row(x, 0), reinterpret_cast<fftw_complex*>(row(x, 0)));
    for (int y = 0; y < points_[1]; ++y) std::copy_n(row(x, y), deep, *modes(x, y));
  });
  team.for_each(points_[1], [&](int y) { filter(y, factor); });
  team.for_each(points_[0], [&](int x) {
    for (int y = 0; y < points_[1]; ++y) std::copy_n(*modes(x, y), deep, row(x, y));
    fftw_execute_dft_c2r(backward_.get(), reinterpret_cast<fftw_complex*>(row(x, 0)), row(x, 0));
    unfold(x);
  });
}

}  // namespace lichtenberg::periodic
