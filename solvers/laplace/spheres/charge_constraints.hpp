#pragma once

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/spheres/initial_guess.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace::spheres {

/// Linear constraints N x = q for given charges. There is a row, a node, for each floating group and, if nothing
/// absorbs the remaining charge, one for all fixed groups. A sphere adds sqrt(R) x_00 to its node.
/// A coupling (lumped capacitance C) has its own unknown z and carries sqrt(C') z from one node to another, C' = C / 4
/// pi eps. Its energy, charge^2 / 2 C, is 2 pi eps z^2, like that of a single sphere of radius C'. N N' is therefore a
/// network with the radii as links to ground and the C' as links between nodes. Its factors keep all digits for any
/// coupling, and couplings do not worsen the condition of the operator.
class ChargeConstraints {
 public:
  /// Sets up the constraints. `start`: start of each sphere's harmonics in x; `couplings`: start of the couplings'
  /// unknowns.
  ChargeConstraints(const SphereProblem& problem, const std::vector<int>& start, int couplings);

  int coupling_count() const { return static_cast<int>(links_.size()); }
  /// Removes from x the part that changes given charges.
  void project(double* x) const;
  /// Adds the shortest vector with the given charges to x, after project() has removed its own part.
  void add(double* x) const;
  /// Moves x, which satisfies the constraints to rounding, to the nearest x with the given charges. Without this,
  /// rounding of the potentials could outweigh the charge that a strong coupling carries.
  void enforce_charges(double* x) const;
  /// Sets the couplings' part of the right-hand side: the fixed potentials at their ends.
  void add_fixed_potentials(double* right_hand_side) const;
  /// Returns the potential (V) of each group, from the residual of x -> x + sqrt(R) b. Without ground the fixed groups
  /// set the level.
  std::vector<double> potentials(const double* missed) const;

  /// Returns the charge (C) through each of the problem's couplings, from a to b.
  std::vector<double> carried(const double* x) const;
  /// Returns the potential difference (V) across each link.
  std::vector<double> differences(const double* x) const;
  void set_differences(std::span<const double> difference, double* x) const;
  /// Returns for each node its spheres and the charge on them, given the potential differences across the links.
  std::vector<ChargeConstraint> on_spheres(std::span<const double> difference) const;

 private:
  /// Coupling with an unknown; end -1: fixed potential, not a node.
  struct Link {
    int a = -1, b = -1;
    int coupling = 0;   ///< Index of the problem's coupling
    double root = 0;    ///< sqrt(C')
    double supply = 0;  ///< Potential (V) of the fixed end, if any, signed by its end: V_b - 0 or 0 - V_a
  };
  std::vector<double> flows(const double* x) const;
  void spread(const std::vector<double>& potential, double sign, double* x) const;

  const SphereProblem* problem_;
  double scale_;  ///< 4 pi eps
  std::vector<int> start_;
  int first_;
  std::vector<int> node_of_group_, node_of_sphere_;
  std::vector<double> root_;    ///< sqrt(R) of each sphere
  std::vector<double> charge_;  ///< Q / 4 pi eps of each node
  int level_ = -1;              ///< Node of all fixed groups
  std::vector<Link> links_;
  NetworkFactors factors_;
};

}  // namespace lichtenberg::laplace::spheres
