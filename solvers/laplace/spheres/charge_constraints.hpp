#pragma once

#include "solvers/laplace/network_factors.hpp"
#include "solvers/laplace/spheres/initial_guess.hpp"
#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace::spheres {

/// Linear constraints N x = q that keep the given charges of floating groups during the solve. x are the unknowns of
/// System, and q the charges over 4 pi eps. There is a constraint, or node, for each floating group. If nothing absorbs
/// the remaining charge, all fixed groups together are a further node. A sphere of radius R contributes sqrt(R) x_00 to
/// its node.
/// A coupling (lumped capacitance C between two groups) with a floating end has an unknown z of its own. It carries the
/// charge 4 pi eps sqrt(C') z from one group to the other, with C' = C / (4 pi eps). Its energy, charge^2 / 2 C, is 2
/// pi eps z^2, like that of a single sphere of radius C'.
/// The matrix N N' is therefore that of a network, with the radii as links to ground and the C' as links between nodes.
/// Its factors keep all digits for any coupling, and couplings do not worsen the condition of the operator.
class ChargeConstraints {
 public:
  /// Sets up the constraints of given charges. `start`: index of each sphere's first harmonic in x; `couplings`: index
  /// of the first coupling's unknown in x.
  ChargeConstraints(const SphereProblem& problem, const std::vector<int>& start, int couplings);

  /// Returns the number of couplings with an unknown of their own.
  int coupling_count() const { return static_cast<int>(links_.size()); }
  /// Projects x orthogonally onto the vectors with N x = 0 (N: matrix of the constraints): removes the part that
  /// changes given charges.
  void project(double* x) const;
  /// Adds to a projected x the shortest vector with the given charges q, so that N x = q (N: matrix of the
  /// constraints).
  void add(double* x) const;
  /// Moves x, which satisfies the charge constraints N x = q up to rounding, to the nearest x that satisfies them.
  /// Without this correction, rounding of the potentials could outweigh the charge that a strong coupling carries.
  void enforce_charges(double* x) const;
  /// Adds the couplings' part of the right-hand side: the fixed potentials at their ends.
  void add_fixed_potentials(double* right_hand_side) const;
  /// Computes the potential (V) of each group from the residual `missed` of the equations without constraints.
  /// Potentials of floating groups are Lagrange multipliers; fixed groups have their given potentials.
  std::vector<double> potentials(const double* missed) const;

  /// Computes the charge (C) that flows through each of the problem's couplings, from its group a to its group b.
  std::vector<double> carried(const double* x) const;
  /// Computes the potential difference (V) across each coupling with an unknown.
  std::vector<double> differences(const double* x) const;
  /// Sets the couplings' unknowns in x from the potential differences (V) across them.
  void set_differences(std::span<const double> difference, double* x) const;
  /// Returns the constraints on the spheres alone, for each node that has spheres: its spheres and their total charge.
  /// `difference`: given potential differences (V) across the couplings.
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
