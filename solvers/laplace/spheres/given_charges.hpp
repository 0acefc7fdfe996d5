#pragma once

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/spheres/first_guess.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace::spheres {

/// Which charges are given, as linear constraints N x = q on the unknowns x: a row, a *node*, for each floating group
/// and, where nothing takes what charge is left, one for all that is fixed. A sphere adds sqrt(R) x_00 to its node. A
/// coupling of capacitance C has an unknown of its own, z, and takes sqrt(C') z from one node to another, C' =
/// C / 4 pi eps: its energy, charge^2 / 2 C, is 2 pi eps z^2, as if it were a lone sphere of radius C'. So N N' is a
/// network, with the radii to ground and the C' as links, whose factors keep all digits however strong a coupling is,
/// and the operator is as well conditioned with couplings as without.
class GivenCharges {
 public:
  /// start: where each sphere's harmonics begin in x; `couplings`: where the couplings' unknowns begin.
  GivenCharges(const SphereProblem& problem, const std::vector<int>& start, int couplings);

  int coupling_count() const { return static_cast<int>(links_.size()); }
  /// Takes off what would change charges that are given.
  void project(double* x) const;
  /// To an x that project has left nothing of: the shortest one with the charges that are given.
  void add(double* x) const;
  /// The nearest x with the charges that are given, of one that has them but for rounding: what a strong coupling
  /// carries is a small part of what rounding in its potentials would.
  void settle(double* x) const;
  /// Sets the couplings' part of the right-hand side: supplies at their ends.
  void add_supplies(double* right_hand_side) const;
  /// V, of each group: from how much x -> x + sqrt(R) b misses the right-hand side. Without ground the fixed ones give
  /// the level.
  std::vector<double> potentials(const double* missed) const;

  /// C, through each of the problem's couplings, from a to b.
  std::vector<double> carried(const double* x) const;
  /// V, across each link.
  std::vector<double> differences(const double* x) const;
  void set_differences(std::span<const double> difference, double* x) const;
  /// By node: its spheres with the charge that is on them if such are the differences across the links.
  std::vector<Given> on_spheres(std::span<const double> difference) const;

 private:
  /// A coupling that is an unknown; -1: the end is fixed, and no node.
  struct Link {
    int a = -1, b = -1;
    int coupling = 0;   ///< of the problem
    double root = 0;    ///< sqrt(C')
    double supply = 0;  ///< V of the fixed end, if there is one, with the sign of its place: V_b - 0 or 0 - V_a
  };
  std::vector<double> flows(const double* x) const;
  void spread(const std::vector<double>& potential, double sign, double* x) const;

  const SphereProblem* problem_;
  double scale_;  ///< 4 pi eps
  std::vector<int> start_;
  int first_;
  std::vector<int> node_of_group_, node_of_sphere_;
  std::vector<double> root_;    ///< sqrt(R) of each sphere
  std::vector<double> charge_;  ///< Q / 4 pi eps, by node
  int level_ = -1;              ///< the node of all that is fixed
  std::vector<Link> links_;
  NetworkFactors factors_;
};

}  // namespace lichtenberg::laplace::spheres
