#pragma once

#include "solvers/random.hpp"

namespace lichtenberg {

/// A charge of the density z / (2 Gamma(1/z)) exp(-|q|^z) (G 3.49), whose variance is Gamma(3/z) / Gamma(1/z): z = 2 is
/// Gaussian, 1 is Laplace's, and z -> infinity is uniform between -1 and 1. |q|^z has a gamma distribution, which is
/// inverted; two words. Throws InputError unless z > 0.
double random_charge(double z, Random& random);

}  // namespace lichtenberg
