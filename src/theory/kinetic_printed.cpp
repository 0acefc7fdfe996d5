#include "src/theory/kinetic_printed.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "src/theory/kinetic.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Functions of G's table 5.1 as printed, with B, its powers, l and l_1.
struct Printed {
  explicit Printed(double bjerrum) : b(bjerrum), b2(b * b), b4(b2 * b2), l(std::sqrt(4 - b2)), l1(std::sqrt(1 - b2)) {}
  double b, b2, b4, l, l1;

  double mergers() const {
    const double a1 = -b2 * l * l * l, a4 = a1;
    const double a2 = l1 * l * b * (-4 + 7 * b2) + l1 * pi * (b2 - 1) * (8 - 4 * l + b2 * (-6 + l));
    const double a3 = 4 * l1 * (4 - 7 * b2 + 3 * b4), a6 = -a3;
    const double a5 = l1 * l * (b * (-4 + 7 * b2) + pi * (4 - 5 * b2 + b4));
    return (a1 * std::atan(l1 / b) + a2 + a3 * std::atan(b / l) + a4 * std::atan(l1 / b) + a5 + a6 * std::atan(l / b)) /
           std::pow(l1 * l, 3);
  }
  double contact_loss() const {
    const double a1 = b * (8 - 5 * b2) * l + pi * (16 - 10 * b2 + 3 * b4), a2 = -32 + 20 * b2 - 6 * b4;
    return (a1 + a2 * std::atan(b / l)) / std::pow(l, 5);
  }
  double merging_loss() const {
    const double a3 = l * (2 * pi * (b2 - 4) * (b2 - 4) + b * (-32 + 28 * b2 + b4));
    const double a4 = -4 * (32 - 20 * b2 + 9 * b4), a6 = -a4;
    const double a5 = l * b * (-32 + 28 * b2 + b4) + 2 * pi * (b2 * (20 - 8 * l) + b4 * (-9 + l) + 16 * (-2 + l));
    return (a3 + a4 * std::atan(l / b) + a5 + a6 * std::atan(b / l)) / std::pow(l, 5);
  }
  double contact_charge() const {
    const double a1 = 2 * b * l * (b2 - 1) - pi * (4 - 2 * b2 + b4), a2 = 2 * (4 - 2 * b2 + b4);
    return (a1 + a2 * std::atan(b / l)) / std::pow(l, 5);
  }
  double merging_charge() const {
    const double root = std::sqrt(pi), l5 = std::pow(l, 5), b6 = b4 * b2;
    const double a3 = 16 * l * root * l1 * std::pow(4 - 5 * b2 + b4, 2), a7 = a3 / 2;
    const double a4 = -root * b * l * (pi * (b2 - 4) * (1 + 2 * b2) + 2 * b * l1 * (-8 - 54 * b2 + 33 * b4 + 2 * b6));
    const double a5 = 2 * root * b * l5 * (1 + 2 * b2), a6 = 16 * root * b * std::pow(l1, 5) * (4 + 5 * b2);
    const double a8 = -root * b * l5 * (1 + 2 * b2), a9 = root * b * l1 * b * l * (8 + 54 * b2 - 33 * b4 - 2 * b6);
    const double a10 = 8 * root * b * l1 * (b2 - 1) * (b2 - 1) * (4 + 5 * b2);
    return (a4 + a5 * std::atan(b / l1) + a6 * std::atan(l / b)) / a3 +
           (a8 * std::atan(l1 / b) + a9 + a10 * std::atan(l / b)) / a7;
  }
};

}  // namespace

KineticFunctions printed_functions(double bjerrum, double exponent) {
  if (!(bjerrum > 0 && bjerrum < 1))
    throw InputError(
        fmt::format("the kinetic functions as printed in Singh 2019 are real for 0 < B < 1, with the ratio B = K <q^2> "
                    "/ (T d) of Coulomb energy to temperature, not for B = {}",
                    bjerrum));
  const Printed g(bjerrum);
  const double root = std::sqrt(pi);
  return {.mergers = g.mergers() / (2 * root),
          .contact_loss = 80 * std::pow(2, 0.2) / (21 * root) * g.contact_loss(),
          .merging_loss = g.merging_loss() / (8 * root),
          .contact_charge = 1.4080 * (2 + exponent) * std::pow(4, exponent + 0.5) / pi * g.contact_charge(),
          .merging_charge = 4 / root * g.merging_charge()};
}

KineticFunctions corrected_functions(double bjerrum, double exponent) {
  const double root = std::sqrt(pi), beta = 2 * bjerrum;
  const MergingIntegrals merging = merging_integrals(beta);
  return {.mergers = 2 / root * merging.number,
          .contact_loss = 5 / (21 * root) * std::pow(4, 1.6) * contact_integral(3.1, beta),
          .merging_loss = 2 / root * merging.energy,
          .contact_charge =
              2 / (root * (exponent + 1)) * std::pow(4, exponent + 0.5) * contact_integral(exponent + 2, beta),
          .merging_charge = 8 / root * merging.charge};
}

}  // namespace lichtenberg::theory
