#pragma once

#include <deque>
#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Solution of a similar scene, kept for initial guesses.
struct PastSolution {
  std::vector<Site> sites;
  std::vector<double> x;             ///< Unknowns sqrt(R) a, harmonics of all sites
  std::vector<double> potential;     ///< Potential of each site (V)
  std::vector<double> wall;          ///< Potential of the sides at each site's centre (V)
  std::vector<double> difference{};  ///< Potential difference across each coupling (V)
};

/// Latest solutions, the most recent first.
using History = std::deque<PastSolution>;
constexpr std::size_t longest_history = 4;

/// Charge constraint: spheres whose total charge is given. They are those of a floating group or, if nothing absorbs
/// the remaining charge, all fixed ones.
struct ChargeConstraint {
  std::vector<int> spheres;
  double charge = 0;  ///< Q / (4 pi eps), the sum of R a_00
  double weight = 0;  ///< Sum of radii
};

/// Target of a solve: positions, charges and potentials.
struct SolveTarget {
  const std::vector<Site>& sites;
  const std::vector<ChargeConstraint>& constraints;
  std::vector<int> group;     ///< Group of each site; sites of one group have one potential
  std::vector<double> fixed;  ///< Potential of each site if fixed (V); otherwise not a number
  std::vector<double> wall;   ///< Potential of the sides at each site's centre (V)
};

/// Returns the coefficients of past solutions in the best initial guess. x is linear in charges and potentials and
/// smooth in positions. The linear combination is therefore chosen that comes closest to the target's charges,
/// potentials and displacements, with the least potential differences within groups. It does not use times, so a step
/// that was rolled back serves as well as any other. `noise`: relative error of each past x; it limits combinations
/// that would amplify it. All solutions must have as many sites as the target.
std::vector<double> history_coefficients(const History& history, const SolveTarget& target, double noise);

}  // namespace lichtenberg::laplace::spheres
