#include "solvers/laplace/spheres/cell_axes.hpp"

#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::spheres {

template <class Scalar>
void multiply_matrices(const Scalar* a, const Scalar* b, Eigen::Index rows, Eigen::Index inner, Eigen::Index columns,
                       Scalar* out) {
  using Matrix = Eigen::Map<const RowMatrix<Scalar>>;
  Eigen::Map<RowMatrix<Scalar>>(out, rows, columns).noalias() = Matrix(a, rows, inner) * Matrix(b, inner, columns);
}
template void multiply_matrices(const float*, const float*, Eigen::Index, Eigen::Index, Eigen::Index, float*);
template void multiply_matrices(const double*, const double*, Eigen::Index, Eigen::Index, Eigen::Index, double*);
template void multiply_matrices(const std::complex<float>*, const std::complex<float>*, Eigen::Index, Eigen::Index,
                                Eigen::Index, std::complex<float>*);
template void multiply_matrices(const std::complex<double>*, const std::complex<double>*, Eigen::Index, Eigen::Index,
                                Eigen::Index, std::complex<double>*);

int odd_axes(int l, int m) {
  return (mirror_sign(l, m, 1) < 0 ? 1 : 0) + (mirror_sign(l, m, 2) < 0 ? 2 : 0) + (mirror_sign(l, m, 4) < 0 ? 4 : 0);
}

double trigonometric(bool odd, double phase) { return odd ? std::sin(phase) : std::cos(phase); }

namespace {

/// Returns the modes of an axis: odd ones only between mirrors of different kinds; all or half of them without mirrors.
std::vector<int> modes_of(const Cells& cells, int axis, bool half) {
  const int n = cells.count[axis], period = cells.period[axis];
  std::vector<int> modes;
  if (cells.mirrored[axis] && period == 4 * n) {
    for (int mode = 1; mode < 2 * n; mode += 2) modes.push_back(mode);
    return modes;
  }
  const int most = cells.mirrored[axis] ? n : half ? period / 2 : period - 1;
  for (int mode = 0; mode <= most; ++mode) modes.push_back(mode);
  return modes;
}

/// Returns the phase of a wave at a cell's centre.
double phase_of(int mode, int cell, int period) { return 2 * std::numbers::pi / period * mode * (cell + 0.5); }

bool is_its_own_conjugate(int mode, int period) { return mode == 0 || 2 * mode == period; }

void add_real_waves(CellAxis& axis, int count, int period) {
  const auto modes = static_cast<Eigen::Index>(axis.mode.size());
  const double copies = static_cast<double>(period) / count;  // Copies of each cell in a period
  for (int odd = 0; odd < 2; ++odd) {
    axis.to[odd].resize(modes, count);
    axis.from[odd].resize(count, modes);
    for (Eigen::Index w = 0; w < modes; ++w)
      for (int i = 0; i < count; ++i) {
        const double value = trigonometric(odd, phase_of(axis.mode[w], i, period));
        axis.to[odd](w, i) = value;
        axis.from[odd](i, w) = value * (is_its_own_conjugate(axis.mode[w], period) ? 1 : 2) * copies / period;
      }
  }
}

void add_complex_waves(CellAxis& axis, int count, int period, bool half) {
  const auto modes = static_cast<Eigen::Index>(axis.mode.size());
  axis.complex_to.resize(modes, count);
  axis.complex_from.resize(count, modes);
  for (Eigen::Index w = 0; w < modes; ++w)
    for (int i = 0; i < count; ++i) {
      const double phase = phase_of(axis.mode[w], i, period);
      const double weight = (half && !is_its_own_conjugate(axis.mode[w], period) ? 2.0 : 1.0) / period;
      axis.complex_to(w, i) = std::polar(1.0, -phase);
      axis.complex_from(i, w) = std::polar(weight, phase);
    }
}

int last_axis_without_mirrors(const Cells& cells) {
  int last = -1;
  for (int k = 0; k < 3; ++k)
    if (!cells.mirrored[k]) last = k;
  return last;
}

}  // namespace

bool has_complex_waves(const Cells& cells) { return last_axis_without_mirrors(cells) >= 0; }

std::array<CellAxis, 3> cell_axes(const Cells& cells) {
  std::array<CellAxis, 3> axes;
  for (int k = 0; k < 3; ++k) {
    // Opposite waves are complex conjugates (for all axes together), so half of the modes of one axis suffices.
    const bool half = k == last_axis_without_mirrors(cells);
    axes[k].mode = modes_of(cells, k, half);
    if (cells.mirrored[k])
      add_real_waves(axes[k], cells.count[k], cells.period[k]);
    else
      add_complex_waves(axes[k], cells.count[k], cells.period[k], half);
  }
  return axes;
}

}  // namespace lichtenberg::laplace::spheres
