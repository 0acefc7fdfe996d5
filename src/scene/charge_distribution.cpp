#include "src/scene/charge_distribution.hpp"

#include <fmt/format.h>

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg {

double random_charge(double z, Random& random) {
  if (!(z > 0)) throw InputError(fmt::format("charges distributed as exp(-|q|^z) need z > 0, not {}", z));
  const double sign = random.sign(), below = random.uniform(), shape = 1 / z;
  // For |q|^z below rounding, the probability of less than |q| is |q| / Gamma(1 + 1/z). The formula also avoids
  // underflow of |q|^z.
  const double small = below * std::tgamma(1 + shape);
  if (std::pow(small, z) < 1e-16) return sign * small;
  return sign * std::pow(boost::math::gamma_p_inv(shape, below), shape);
}

namespace {

double drawn(const PopulationDraft& population, Random& random) {
  if (population.charge_distribution == ChargeDistribution::gaussian) return random.normal();
  return random_charge(*population.charge_exponent, random);
}

/// Makes the charges multiples of the quantum with a sum of exactly 0. It subtracts their mean, rounds, and distributes
/// the remainder of the rounding, one quantum to a grain.
void neutralize(std::vector<double>& charges, double quantum) {
  const auto sum = [&] { return std::accumulate(charges.begin(), charges.end(), 0.0); };
  const double mean = sum() / static_cast<double>(charges.size());
  for (double& charge : charges) charge = quantum * std::nearbyint((charge - mean) / quantum);
  const double left = sum();  // exact sum of multiples of the quantum
  for (std::size_t k = 0; static_cast<double>(k) * quantum < std::abs(left); ++k)
    charges[k] -= std::copysign(quantum, left);
}

}  // namespace

std::vector<double> charges_of(const PopulationDraft& population, std::uint64_t seed, std::size_t first) {
  std::vector<double> charges(population.count, population.charge);
  if (population.charge_distribution == ChargeDistribution::equal || population.charge == 0) return charges;
  for (std::size_t k = 0; k < charges.size(); ++k) {
    Random random({.seed = seed, .purpose = RandomPurpose::population, .i = first + k, .j = 1});
    charges[k] *= drawn(population, random);
  }
  neutralize(charges, std::ldexp(1.0, std::ilogb(population.charge) - 30));
  return charges;
}

}  // namespace lichtenberg
