#pragma once

#include "solvers/laplace/spheres/cell_axes.hpp"
#include "solvers/laplace/spheres/images.hpp"

namespace lichtenberg::laplace::spheres {

/// Computes the field of a unit charge in one cell at all far cells, as derivatives for Coupling in powers of `unit`.
/// The result holds Fourier coefficients on the continued grid, [harmonics(degree)][mode, z fastest]. They are divided
/// by (-i)^(number of axes in which the harmonic is odd), which makes them real. In a bounded box Ewald's sums include
/// the images.
RowMatrix<double> cell_kernel(const Mirrors& mirrors, const Cells& cells, const std::array<CellAxis, 3>& axes,
                              int degree, double unit, double accuracy);

}  // namespace lichtenberg::laplace::spheres
