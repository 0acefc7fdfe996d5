#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/spheres/cells.hpp"

namespace lichtenberg::laplace::spheres {

template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Returns the axes along which C_lm is odd: bit k for axis k.
int odd_axes(int l, int m);
/// Returns sin (odd) or cos (even) of the phase.
double trigonometric(bool odd, double phase);

/// Fourier transforms along one axis of the continued grid. On an axis with mirrors functions are even or odd, and
/// cosines or sines of the cells inside suffice.
struct CellAxis {
  std::vector<int> mode;                      ///< Wave numbers in units of 2 pi / period
  std::array<RowMatrix<double>, 2> to, from;  ///< For even and for odd functions: [mode][cell], [cell][mode]
  RowMatrix<std::complex<double>> complex_to, complex_from;  ///< Matrices for an axis without mirrors
};

/// Returns true if an axis has no mirrors, so that waves are complex.
bool has_complex_waves(const Cells& cells);
std::array<CellAxis, 3> cell_axes(const Cells& cells);

}  // namespace lichtenberg::laplace::spheres
