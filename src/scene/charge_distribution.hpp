#pragma once

#include <cstdint>
#include <vector>

#include "solvers/random.hpp"
#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Draws a random charge q with the probability density z / (2 Gamma(1/z)) exp(-|q|^z) (G 3.49), by inversion of the
/// gamma distribution of |q|^z. The variance is Gamma(3/z) / Gamma(1/z). z = 2 is Gaussian, z = 1 is Laplace's
/// distribution, and z -> infinity is uniform between -1 and 1. The function takes two numbers from `random`. Throws
/// InputError unless z > 0.
double random_charge(double z, Random& random);

/// Draws the charges of a population of grains: all equal, or random with a sum of exactly 0. `first`: index in the
/// scene of its first grain, which gives each grain its own random numbers. The mean of the random charges is
/// subtracted from each. They are then rounded to multiples of a power of two, about 2^-30 of their width.
std::vector<double> charges_of(const PopulationDraft& population, std::uint64_t seed, std::size_t first);

}  // namespace lichtenberg
