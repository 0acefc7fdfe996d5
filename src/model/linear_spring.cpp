#include "src/model/linear_spring.hpp"

#include <fmt/format.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <tuple>

#include "solvers/error.hpp"

namespace lichtenberg {

double linear_damping(double stiffness, double restitution, double effective_mass) {
  if (!(restitution > 0 && restitution <= 1))
    throw InputError(
        fmt::format("the restitution coefficient of a linear contact is {}; it must lie in (0, 1]", restitution));
  const double wanted = -std::log(restitution);
  const auto excess = [&](double z) { return 2 * z * arc_over_sine(z) - wanted; };
  // The function rises with z, and for z >= 1 it is at least 2 acosh(z) >= 2 ln z.
  double low = 0, high = 1 / std::sqrt(restitution);
  std::uintmax_t iterations = 100;
  if (wanted > 0)
    std::tie(low, high) = boost::math::tools::toms748_solve(excess, low, high, -wanted, excess(high),
                                                            boost::math::tools::eps_tolerance<double>(52), iterations);
  else
    high = 0;
  return (low + high) * std::sqrt(stiffness * effective_mass);
}

}  // namespace lichtenberg
