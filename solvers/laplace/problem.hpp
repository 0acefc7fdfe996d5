#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "solvers/geometry/shape.hpp"

namespace lichtenberg::laplace {

/// One side of the rectangular domain.
struct Side {
  enum class Kind { insulating, electrode } kind = Kind::insulating;
  double potential = 0;  ///< Potential (V) of an electrode
  /// Potential along the side, V(p), of an electrode with varying potential; optional. Validation uses it to impose the
  /// exact field of an unbounded problem on the walls, which removes the box's error. Several threads call it at once.
  std::function<double(Vec2)> profile;

  double potential_at(Vec2 p) const { return profile ? profile(p) : potential; }
};

enum SideIndex { left = 0, right = 1, bottom = 2, top = 3 };

class LinkModel;

/// Perfect conductor: its shape and the group whose potential it has. Bodies of one group need not touch.
struct Body {
  Shape shape;
  int group = 0;
  /// Conductance model of the cut-cell method's links to the surface (cutcell/surface_links.hpp); null: that of a bare
  /// conductor. Must outlive the problem. Other methods refuse it.
  const LinkModel* link_model = nullptr;
};

/// Group of bodies with one potential. Floating: the total charge is given and the potential unknown. Fixed: the
/// potential is given and the charge follows.
struct Group {
  bool floating = true;
  double charge = 0;     ///< Charge (C per metre of depth), if floating
  double potential = 0;  ///< Potential (V), if fixed
};

/// Lumped capacitance between two groups, in addition to the field: the charge capacitance * (V_a - V_b) flows from a
/// to b. The charge balance of a floating group is
///   Q_field(a) + sum over its couplings of capacitance * (V_a - V_b) = charge of a.
/// A conductance g over a time dt, integrated implicitly, has this form: dQ_a/dt = J_a - g (V_a - V_b) becomes the
/// balance above. Then capacitance = dt g and charge = Q_a + dt J_a (D 5.5, with J and Ohm's law). Infinite capacitance
/// is the limit in which a and b are one group (D 5.3), zero that without coupling. Either group may be fixed, also
/// without a body: a potential source behind a resistor.
struct Coupling {
  int a = 0, b = 0;        ///< Indices of the groups
  double capacitance = 0;  ///< Capacitance (F per metre of depth); finite, not negative
};

/// Laplace's equation div(eps grad V) = 0 in the box [0, size.x] x [0, size.y] outside the bodies (D 5.2-5.4). It is
/// two-dimensional: all charges, forces and energies are per metre of depth.
struct LaplaceProblem {
  Vec2 size;
  std::array<Side, 4> sides;  ///< Sides by SideIndex
  double permittivity = 0;    ///< Permittivity (F/m); required
  std::vector<Body> bodies;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< Couplings between groups; those between the same two add up
  int movable = -1;                 ///< Number of leading bodies whose forces count in measures of accuracy; -1: all

  /// Returns true if an electrode side or a body has a given potential.
  bool has_fixed_conductor() const;
  /// Returns false if no conductor in the field, or coupled to one, has a given potential. The charges must sum to zero
  /// then. The potential is determined up to a constant, chosen such that the groups' potentials, weighted by their
  /// number of bodies, have zero mean.
  bool has_ground() const;
  /// Checks the problem. Throws InputError if a body or a coupling refers to no group, or if a coupling joins a group
  /// to itself. Throws InputError if a size, radius or permittivity is not positive, or if a capacitance is negative.
  /// Throws InputError if a number is not finite or an insulating side has a potential profile. Throws InputError for a
  /// floating group without a body or a coupling to a group that has a body or a given potential. Throws InputError if
  /// nothing is grounded and the charges do not sum to zero.
  void check() const;
};

/// Returns for each group the first group of its coupled set: groups connected by couplings of more than `least` (F/m).
std::vector<int> coupled_sets(const LaplaceProblem& problem, double least = 0);
std::vector<int> coupled_sets(int groups, std::span<const Coupling> couplings, double least = 0);

/// Throws InputError if there are couplings, for methods without support of them. `method` begins the error message.
void refuse_couplings(const LaplaceProblem& problem, const std::string& method);

/// Throws InputError if a body has a link model, for methods without links. `method` begins the error message.
void refuse_link_models(const LaplaceProblem& problem, const std::string& method);

/// Wall times of the parts of a solve (s).
struct Timings {
  double setup = 0;   ///< Links, levels, coarse factorization
  double solve = 0;   ///< Krylov or relaxation iterations
  double forces = 0;  ///< Charges, forces, energy
};

struct LaplaceSolution {
  std::vector<double> group_potential;  ///< Potential of each group (V)
  std::vector<double> body_charge;      ///< Field charge of each body (C/m), without charge through couplings
  std::vector<Vec2> body_force;         ///< Force on each body (N/m)
  std::array<double, 4> side_charge{};  ///< Charge on each side of the box if it is an electrode (C/m)
  double energy = 0;                    ///< Energy (J/m), eps/2 integral |grad V|^2
  long unknowns = 0;
  int iterations = 0;
  double work = 0;      ///< Operator evaluations, in units of residual evaluations on the whole grid; 0: not counted
  double residual = 0;  ///< Final relative residual, in the norm of the solver's stopping criterion
  Timings seconds;
};

/// Potential at cell centres: value[j * nx + i] at ((i + 0.5) h, (j + 0.5) h); inside a conductor, its potential.
struct Field {
  int nx = 0, ny = 0;
  double h = 0;               ///< Cell edge (m)
  std::vector<double> value;  ///< Potential (V)
  std::vector<int> body;      ///< Index of the body that contains the centre, -1 in the fluid
};

/// Interface of all field solvers. Solvers keep data that speed up the next call on a similar scene (buffers, the last
/// potentials as initial guess). `forget` discards them, so that the next solve depends on its problem only.
class LaplaceSolver {
 public:
  virtual ~LaplaceSolver() = default;
  /// Solves the problem. Throws the exceptions of LaplaceProblem::check. Throws InputError for a problem that the
  /// method does not support, Failure if the iteration does not converge.
  virtual LaplaceSolution solve(const LaplaceProblem& problem) = 0;
  /// Returns the potential of the last solve. Throws Failure if nothing has been solved.
  virtual Field field() const = 0;
  virtual void forget() = 0;
};

/// Returns the capacitance matrix C (row-major, groups x groups; F/m): charge on group i with group j at 1 V, every
/// other group and electrode side at 0 V (D 6.20). In a box without an electrode the rows sum to zero. Throws the
/// exceptions of `solver`.
std::vector<double> capacitance_matrix(LaplaceSolver& solver, const LaplaceProblem& problem);

}  // namespace lichtenberg::laplace
