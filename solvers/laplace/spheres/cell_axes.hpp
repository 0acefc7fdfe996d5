#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/spheres/cells.hpp"

namespace lichtenberg::laplace::spheres {

template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Bit k: C_lm is odd along axis k.
int odd_axes(int l, int m);
/// sin or cos.
double trigonometric(bool odd, double phase);

/// To and from the Fourier coefficients along one axis of the continued grid. Where it has mirrors, functions are even
/// or odd, and cosines or sines of the cells inside are all there is.
struct CellAxis {
  std::vector<int> mode;                      ///< wave numbers in units of 2 pi / period
  std::array<RowMatrix<double>, 2> to, from;  ///< of even and of odd functions: [mode][cell], [cell][mode]
  RowMatrix<std::complex<double>> complex_to, complex_from;  ///< the same without mirrors
};

/// Whether an axis has no mirrors, so that waves are complex.
bool has_complex_waves(const Cells& cells);
std::array<CellAxis, 3> cell_axes(const Cells& cells);

}  // namespace lichtenberg::laplace::spheres
