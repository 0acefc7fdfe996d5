#include "solvers/laplace/spheres/cell_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/laplace/spheres/lattice.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

using Index3 = std::array<int, 3>;

/// Kernel in one octant of a period, continued by symmetry: first at the grid's points, then at its waves.
class Octant {
 public:
  Octant(const Mirrors& mirrors, const Cells& cells, int degree, double accuracy)
      : mirrors_(mirrors), cells_(cells), degree_(degree), split_(ewald_split(cells.range, accuracy)) {
    for (int k = 0; k < 3; ++k) half_[k] = cells.period[k] / 2;
    fill_grid();
    transform_to_waves();
    if (mirrors_.bounded) add_long_waves();
  }
  /// Returns the value at any wave numbers of a period.
  double at_wave(int l, int m, const Index3& mode) const {
    const int odd = odd_axes(l, m);
    Index3 folded = mode;
    double sign = 1;
    for (int k = 0; k < 3; ++k) {
      if (mode[k] <= half_[k]) continue;
      folded[k] = cells_.period[k] - mode[k];
      if (odd >> k & 1) sign = -sign;
    }
    return sign * value_(at(l, m), index(folded));
  }

 private:
  Eigen::Index index(const Index3& at) const {
    return (static_cast<Eigen::Index>(at[0]) * (half_[1] + 1) + at[1]) * (half_[2] + 1) + at[2];
  }
  void fill_grid();
  Eigen::VectorXd in_free_space(const Index3& at) const;
  Eigen::VectorXd screened_copies(const Index3& at) const;
  RowMatrix<double> sums(int axis, bool odd) const;
  void transform_to_waves();
  void add_long_waves();
  void add_long_wave(Vec3 wave, const Index3& folded, std::vector<double>& harmonic);
  double points() const { return static_cast<double>(cells_.period[0]) * cells_.period[1] * cells_.period[2]; }

  const Mirrors& mirrors_;
  const Cells& cells_;
  int degree_;
  EwaldSplit split_;
  Index3 half_{};
  RowMatrix<double> value_;  ///< Layout [harmonics][index]
};

void Octant::fill_grid() {
  value_.resize(harmonics(degree_), index(half_) + 1);
  Index3 at;
  for (at[0] = 0; at[0] <= half_[0]; ++at[0])
    for (at[1] = 0; at[1] <= half_[1]; ++at[1])
      for (at[2] = 0; at[2] <= half_[2]; ++at[2])
        value_.col(index(at)) = mirrors_.bounded ? screened_copies(at) : in_free_space(at);
}

Eigen::VectorXd Octant::in_free_space(const Index3& at) const {
  Eigen::VectorXd value = Eigen::VectorXd::Zero(harmonics(degree_));
  const auto [x, y, z] = at;
  const bool beyond = 2 * x == cells_.period[0] || 2 * y == cells_.period[1] || 2 * z == cells_.period[2];
  if (!beyond && !cells_.is_near(x, y, z)) irregular_harmonics(cells_.displacement(x, y, z), degree_, value.data());
  return value;
}

/// Returns the real-space part of Ewald's sum at this cell offset: all copies of a charge, up to whole periods.
Eigen::VectorXd Octant::screened_copies(const Index3& at) const {
  std::vector<double> term(harmonics(degree_));
  Eigen::VectorXd value = Eigen::VectorXd::Zero(harmonics(degree_));
  Index3 low, high;
  for (int k = 0; k < 3; ++k) {
    const double most = split_.cutoff / cells_.edge[k];
    low[k] = static_cast<int>(std::ceil((-most - at[k]) / cells_.period[k]));
    high[k] = static_cast<int>(std::floor((most - at[k]) / cells_.period[k]));
  }
  for (int a = low[0]; a <= high[0]; ++a)
    for (int b = low[1]; b <= high[1]; ++b)
      for (int c = low[2]; c <= high[2]; ++c) {
        const int x = at[0] + a * cells_.period[0], y = at[1] + b * cells_.period[1], z = at[2] + c * cells_.period[2];
        const Vec3 displacement = cells_.displacement(x, y, z);
        if (norm(displacement) < split_.cutoff)
          add_screened(displacement, {split_.alpha, cells_.is_near(x, y, z), 1}, degree_, term.data(), value.data());
      }
  return value;
}

/// Returns the matrix of sums over a period with cosines or sines, from its first half: [wave number][cell].
RowMatrix<double> Octant::sums(int axis, bool odd) const {
  const int half = half_[axis], period = cells_.period[axis];
  RowMatrix<double> sum(half + 1, half + 1);
  for (int w = 0; w <= half; ++w)
    for (int i = 0; i <= half; ++i)
      sum(w, i) = (i == 0 || 2 * i == period ? 1 : 2) * trigonometric(odd, 2 * std::numbers::pi * w * i / period);
  return sum;
}

/// Transforms axis by axis.
void Octant::transform_to_waves() {
  std::array<std::array<RowMatrix<double>, 2>, 3> sum;
  for (int k = 0; k < 3; ++k)
    for (int odd = 0; odd < 2; ++odd) sum[k][odd] = sums(k, odd);
  const auto [nx, ny, nz] = Index3{half_[0] + 1, half_[1] + 1, half_[2] + 1};
  const std::array<RowMatrix<double>, 2> along_z{sum[2][0].transpose(), sum[2][1].transpose()};
  std::vector<double> product(static_cast<std::size_t>(value_.cols()));
  for (int l = 0; l <= degree_; ++l)
    for (int m = -l; m <= l; ++m) {
      const int odd = odd_axes(l, m);
      double* row = value_.row(at(l, m)).data();
      multiply_matrices(row, along_z[odd >> 2 & 1].data(), nx * ny, nz, nz, product.data());
      for (int i = 0; i < nx; ++i)
        multiply_matrices(sum[1][odd >> 1 & 1].data(), product.data() + index({i, 0, 0}), ny, ny, nz,
                          row + index({i, 0, 0}));
      multiply_matrices(sum[0][odd & 1].data(), row, nx, nx, ny * nz, product.data());
      std::ranges::copy(product, row);
    }
}

/// Adds the reciprocal-space part of Ewald's sum; waves that are aliases on the grid are added up.
void Octant::add_long_waves() {
  std::array<double, 3> unit;
  Index3 high;
  for (int k = 0; k < 3; ++k) {
    unit[k] = 2 * std::numbers::pi / mirrors_.period[k];
    high[k] = static_cast<int>(split_.largest_wave / unit[k]);
  }
  const auto folded = [&](int k, int w) { return (w % cells_.period[k] + cells_.period[k]) % cells_.period[k]; };
  std::vector<double> harmonic(harmonics(degree_));
  for (int x = -high[0]; x <= high[0]; ++x)
    for (int y = -high[1]; y <= high[1]; ++y)
      for (int z = -high[2]; z <= high[2]; ++z) {
        const Vec3 wave{x * unit[0], y * unit[1], z * unit[2]};
        if (norm2(wave) == 0 || norm2(wave) > split_.largest_wave * split_.largest_wave) continue;
        add_long_wave(wave, {folded(0, x), folded(1, y), folded(2, z)}, harmonic);
      }
  value_(0, 0) -= points() * std::numbers::pi / (split_.alpha * split_.alpha * mirrors_.volume());
}

void Octant::add_long_wave(Vec3 wave, const Index3& folded, std::vector<double>& harmonic) {
  for (int k = 0; k < 3; ++k)
    if (folded[k] > half_[k]) return;
  regular_harmonics(wave, degree_, harmonic.data());
  const double k2 = norm2(wave);
  double factor =
      points() * 4 * std::numbers::pi / mirrors_.volume() / k2 * std::exp(-k2 / (4 * split_.alpha * split_.alpha));
  for (int l = 0; l <= degree_; ++l) {
    if (l > 0) factor /= 2 * l - 1;
    for (int m = -l; m <= l; ++m) {
      const int odd = odd_axes(l, m), odds = (odd & 1) + (odd >> 1 & 1) + (odd >> 2 & 1);
      value_(at(l, m), index(folded)) += ((l - odds) / 2 & 1 ? -1 : 1) * factor * harmonic[at(l, m)];
    }
  }
}

}  // namespace

RowMatrix<double> cell_kernel(const Mirrors& mirrors, const Cells& cells, const std::array<CellAxis, 3>& axes,
                              int degree, double unit, double accuracy) {
  const Octant octant(mirrors, cells, degree, accuracy);
  RowMatrix<double> kernel(harmonics(degree), static_cast<Eigen::Index>(axes[0].mode.size()) *
                                                  static_cast<Eigen::Index>(axes[1].mode.size()) *
                                                  static_cast<Eigen::Index>(axes[2].mode.size()));
  double power = unit;
  for (int l = 0; l <= degree; ++l, power *= unit)
    for (int m = -l; m <= l; ++m) {
      Eigen::Index w = 0;
      for (const int x : axes[0].mode)
        for (const int y : axes[1].mode)
          for (const int z : axes[2].mode) kernel(at(l, m), w++) = power * octant.at_wave(l, m, {x, y, z});
    }
  return kernel;
}

}  // namespace lichtenberg::laplace::spheres
