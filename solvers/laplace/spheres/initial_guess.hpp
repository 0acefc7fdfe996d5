#pragma once

#include <deque>
#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Solution of an earlier solve with the same number of spheres, kept for initial guesses.
struct PastSolution {
  std::vector<Site> sites;
  std::vector<double> x;             ///< Unknowns sqrt(R) a, harmonics of all sites
  std::vector<double> potential;     ///< Potential of each site (V)
  std::vector<double> wall;          ///< Potential of the sides at each site's centre (V)
  std::vector<double> difference{};  ///< Potential difference across each coupling (V)
};

/// Latest solutions, the most recent first.
using History = std::deque<PastSolution>;
/// Number of solutions that a history keeps.
constexpr std::size_t longest_history = 4;

/// Charge constraint: spheres whose total charge is given. They are the spheres of a floating group or, if nothing
/// absorbs the remaining charge, the spheres of all fixed groups.
struct ChargeConstraint {
  std::vector<int> spheres;
  double charge = 0;  ///< Q / (4 pi eps), the sum of R a_00
  double weight = 0;  ///< Sum of radii
};

/// Conditions that the solution of a solve must satisfy: positions of the spheres, given charges and potentials.
struct SolveTarget {
  const std::vector<Site>& sites;
  const std::vector<ChargeConstraint>& constraints;
  std::vector<int> group;     ///< Group of each site; sites of one group have one potential
  std::vector<double> fixed;  ///< Potential of each site if fixed (V); otherwise not a number
  std::vector<double> wall;   ///< Potential of the sides at each site's centre (V)
};

/// Computes the coefficients of an initial guess that is a linear combination of past solutions; returns one for each.
/// The solution x is linear in charges and potentials and smooth in positions. The coefficients are therefore a
/// least-squares fit to the target's charges, potentials and positions, with small potential differences within groups.
/// The fit does not use times, so solutions of steps that were rolled back serve equally. `noise`: relative error of
/// each past x, which limits combinations that would amplify it (regularization). The history must not be empty, and
/// all its solutions must have as many sites as the target.
std::vector<double> history_coefficients(const History& history, const SolveTarget& target, double noise);

}  // namespace lichtenberg::laplace::spheres
