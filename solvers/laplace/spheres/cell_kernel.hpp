#pragma once

#include "solvers/laplace/spheres/cell_axes.hpp"
#include "solvers/laplace/spheres/images.hpp"

namespace lichtenberg::laplace::spheres {

/// What a unit charge in one cell makes in those that are not near, as derivatives for Coupling in powers of `unit`:
/// its Fourier coefficients on the continued grid, [harmonics(degree)][mode, z fastest], over (-i)^(number of axes in
/// which the harmonic is odd), which leaves real numbers. Between sides and on periodic axes by Ewald's sums.
RowMatrix<double> cell_kernel(const Mirrors& mirrors, const Cells& cells, const std::array<CellAxis, 3>& axes,
                              int degree, double unit, double accuracy);

}  // namespace lichtenberg::laplace::spheres
