#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "solvers/laplace/spheres/cells.hpp"

namespace lichtenberg::laplace::spheres {

/// Dense matrix in row-major order.
template <class Scalar>
using RowMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Computes out = a b of contiguous matrices in row-major order: a [rows][inner], b [inner][columns]. Defined for real
/// and complex numbers of both precisions, and compiled once, because products take seconds to compile.
template <class Scalar>
void multiply_matrices(const Scalar* a, const Scalar* b, Eigen::Index rows, Eigen::Index inner, Eigen::Index columns,
                       Scalar* out);

/// Returns the axes along which the harmonic C_lm is odd, as bits: bit k is set for axis k.
int odd_axes(int l, int m);
/// Returns sin(phase) if `odd` is true, otherwise cos(phase).
double trigonometric(bool odd, double phase);

/// Matrices of the Fourier transforms between cells and waves along one axis of the grid, continued by images. On an
/// axis with mirrors functions are even or odd, and cosine or sine transforms of the cells inside suffice.
struct CellAxis {
  std::vector<int> mode;                      ///< Wave numbers in units of 2 pi / period
  std::array<RowMatrix<double>, 2> to, from;  ///< For even and odd functions: forward [mode][cell], back [cell][mode]
  RowMatrix<std::complex<double>> complex_to, complex_from;  ///< Matrices for an axis without mirrors
};

/// Returns true if any axis has no mirrors, so that Fourier coefficients are complex.
bool has_complex_waves(const Cells& cells);
/// Makes the matrices of the Fourier transforms between cells and waves for all three axes.
std::array<CellAxis, 3> cell_axes(const Cells& cells);

}  // namespace lichtenberg::laplace::spheres
