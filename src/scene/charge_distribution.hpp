#pragma once

#include <cstdint>
#include <vector>

#include "solvers/random.hpp"
#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Returns a random charge q with the density z / (2 Gamma(1/z)) exp(-|q|^z) (G 3.49). Its variance is Gamma(3/z) /
/// Gamma(1/z). z = 2 is Gaussian, z = 1 is Laplace's distribution, and z -> infinity is uniform between -1 and 1. The
/// method inverts the gamma distribution of |q|^z and takes two random words. Throws InputError unless z > 0.
double random_charge(double z, Random& random);

/// Returns the charges of a population of grains, all equal or drawn at random. `first` is the scene's index of its
/// first grain. Each random charge has its own random numbers. The mean of the random charges is then subtracted from
/// each. Random charges are multiples of a power of two, about 2^-30 of their width, and their sum is exactly 0.
std::vector<double> charges_of(const PopulationDraft& population, std::uint64_t seed, std::size_t first);

}  // namespace lichtenberg
