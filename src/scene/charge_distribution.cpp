#include "src/scene/charge_distribution.hpp"

#include <fmt/format.h>

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg {

double random_charge(double z, Random& random) {
  if (!(z > 0)) throw InputError(fmt::format("charges distributed as exp(-|q|^z) need z > 0, not {}", z));
  const double sign = random.sign(), below = random.uniform(), shape = 1 / z;
  // Where |q|^z is below rounding, and soon below all numbers, the probability of less than |q| is |q| / Gamma(1 +
  // 1/z).
  const double small = below * std::tgamma(1 + shape);
  if (std::pow(small, z) < 1e-16) return sign * small;
  return sign * std::pow(boost::math::gamma_p_inv(shape, below), shape);
}

}  // namespace lichtenberg
