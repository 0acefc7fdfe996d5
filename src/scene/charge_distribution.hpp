#pragma once

#include <cstdint>
#include <vector>

#include "solvers/random.hpp"
#include "src/scene/draft.hpp"

namespace lichtenberg {

/// A charge of the density z / (2 Gamma(1/z)) exp(-|q|^z) (G 3.49), whose variance is Gamma(3/z) / Gamma(1/z): z = 2 is
/// Gaussian, 1 is Laplace's, and z -> infinity is uniform between -1 and 1. |q|^z has a gamma distribution, which is
/// inverted; two words. Throws InputError unless z > 0.
double random_charge(double z, Random& random);

/// Charges of a population of grains, the first of which is the scene's `first`-th: all alike, or drawn, each by random
/// numbers of its own, and then all moved by their mean. Those drawn are multiples of a power of two, 2^-30 of their
/// width, and their sum is exactly 0.
std::vector<double> charges_of(const PopulationDraft& population, std::uint64_t seed, std::size_t first);

}  // namespace lichtenberg
