#pragma once

#include "solvers/laplace/spheres/cell_axes.hpp"
#include "solvers/laplace/spheres/images.hpp"

namespace lichtenberg::laplace::spheres {

/// Computes the convolution kernel between far cells. It contains the potential of a unit charge at the centre of one
/// cell, and its derivatives D_nm (Coupling in lattice.hpp), at the centres of all far cells. In a bounded box, Ewald
/// sums include all periodic copies of the charge. `unit`: unit of length of the derivatives (m); `accuracy`: relative
/// error of the Ewald sums. Returns the Fourier coefficients of the kernel on the grid continued by images,
/// [harmonics(degree)][mode, z fastest]. They are divided by (-i)^(number of axes in which the harmonic is odd), which
/// makes them real.
RowMatrix<double> cell_kernel(const Mirrors& mirrors, const Cells& cells, const std::array<CellAxis, 3>& axes,
                              int degree, double unit, double accuracy);

}  // namespace lichtenberg::laplace::spheres
