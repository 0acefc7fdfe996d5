#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "solvers/geometry/shape.hpp"

namespace lichtenberg::laplace {

/// Boundary condition at one side of the rectangular box: insulating (Neumann boundary condition, zero normal field) or
/// an electrode (Dirichlet boundary condition, given potential).
struct Side {
  enum class Kind { insulating, electrode } kind = Kind::insulating;
  double potential = 0;  ///< Potential (V) of an electrode
  /// Potential along the side, V(p), of an electrode with varying potential; optional. Validation uses it to impose the
  /// exact field of an unbounded problem on the walls, which removes the box's error. Several threads call it at once.
  std::function<double(Vec2)> profile;

  /// Returns the potential (V) of the electrode at a point p (m) of the side.
  double potential_at(Vec2 p) const { return profile ? profile(p) : potential; }
};

/// Indices of the box's sides.
enum SideIndex { left = 0, right = 1, bottom = 2, top = 3 };

class LinkModel;

/// Body: a perfect conductor with its shape and the index of its group (bodies at one potential). Bodies of one group
/// need not touch.
struct Body {
  Shape shape;
  int group = 0;
  /// Model of the conductances between the body's surface and near cells in the cut-cell method
  /// (cutcell/surface_links.hpp); null: bare conductor. Must outlive the problem. Other methods refuse it.
  const LinkModel* link_model = nullptr;
};

/// Equipotential group of bodies. Floating: the total charge is given and the potential unknown. Fixed: the potential
/// is given and the charge follows.
struct Group {
  bool floating = true;
  double charge = 0;     ///< Charge (C per metre of depth), if floating
  double potential = 0;  ///< Potential (V), if fixed
};

/// Coupling: a lumped capacitance between groups a and b in addition to the field. The charge capacitance * (V_a - V_b)
/// flows through it from a to b. The charge balance of a floating group is
///   Q_field(a) + sum over its couplings of capacitance * (V_a - V_b) = charge of a.
/// A resistor of conductance g over an implicit time step dt has this form: dQ_a/dt = J_a - g (V_a - V_b) becomes the
/// balance above, with a current source J_a. Then capacitance = dt g and charge = Q_a + dt J_a (Stephenson 2018,
/// D 5.5). In the limit of infinite capacitance a and b are one group (D 5.3). Either group may be fixed, also without
/// a body: a potential source behind a resistor.
struct Coupling {
  int a = 0, b = 0;        ///< Indices of the groups
  double capacitance = 0;  ///< Capacitance (F per metre of depth); finite, not negative
};

/// Boundary value problem of electrostatics in the plane: Laplace's equation div(eps grad V) = 0 in the box [0, size.x]
/// x [0, size.y] outside the bodies (Stephenson 2018, D 5.2-5.4). All charges, forces and energies are per metre of
/// depth.
struct LaplaceProblem {
  Vec2 size;                  ///< Width and height of the box (m)
  std::array<Side, 4> sides;  ///< Sides by SideIndex
  double permittivity = 0;    ///< Permittivity (F/m); required
  std::vector<Body> bodies;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< Couplings between groups; those between the same two add up
  int movable = -1;                 ///< Number of leading bodies whose forces count in measures of accuracy; -1: all

  /// Returns true if an electrode side or a body has a given potential.
  bool has_fixed_conductor() const;
  /// Returns true if the problem determines the level of the potential: a side, a body or a group coupled to a body has
  /// a given potential. Otherwise the charges must sum to zero. The potential is then determined up to a constant, for
  /// which the mean of the bodies' potentials is zero.
  bool has_ground() const;
  /// Checks the problem, and throws InputError in these cases. A body or a coupling refers to no group, or a coupling
  /// joins a group to itself. A size, radius or permittivity is not positive, a capacitance is negative, or a number is
  /// not finite. An insulating side has a potential profile. A floating group has no body and no path of couplings to a
  /// group with a body or a given potential. Nothing is grounded and the charges do not sum to zero.
  void check() const;
};

/// Finds the sets of groups that are connected by couplings of more than `least` (F/m): the connected components of the
/// circuit. Returns for each group the lowest group number of its set.
std::vector<int> coupled_sets(const LaplaceProblem& problem, double least = 0);
/// Finds the sets of groups that are connected by couplings of more than `least` (F/m), from the number of groups and
/// the couplings. Returns for each group the lowest group number of its set.
std::vector<int> coupled_sets(int groups, std::span<const Coupling> couplings, double least = 0);

/// Throws InputError if the problem has couplings, for methods that do not support them. `method` is the subject of the
/// error message.
void refuse_couplings(const LaplaceProblem& problem, const std::string& method);

/// Throws InputError if a body has a link model (Body::link_model), for methods that do not support it. `method` is the
/// subject of the error message.
void refuse_link_models(const LaplaceProblem& problem, const std::string& method);

/// Throws InputError if a body is a closed curve (Freeform), for methods that do not support it. `method` is the
/// subject of the error message.
void refuse_curves(const LaplaceProblem& problem, const std::string& method);

/// Wall times of the parts of a field solve (s).
struct Timings {
  double setup = 0;   ///< Geometry, multigrid levels, factorizations
  double solve = 0;   ///< Krylov or relaxation iterations
  double forces = 0;  ///< Charges, forces, energy
};

/// Results of a field solve, per metre of depth.
struct LaplaceSolution {
  std::vector<double> group_potential;  ///< Potential of each group (V)
  std::vector<double> body_charge;      ///< Field charge of each body (C/m), without charge through couplings
  std::vector<Vec2> body_force;         ///< Force on each body (N/m)
  /// Torque on each closed curve about its centroid (N), 0 for other bodies; empty if no body is a closed curve
  std::vector<double> body_torque;
  std::array<double, 4> side_charge{};  ///< Charge on each side of the box if it is an electrode (C/m)
  double energy = 0;                    ///< Electrostatic energy of the field (J/m), eps/2 integral |grad V|^2
  long unknowns = 0;                    ///< Number of unknowns of the solver
  int iterations = 0;                   ///< Number of iterations of the solver
  double work = 0;      ///< Operator evaluations, in units of residual evaluations on the whole grid; 0: not counted
  double residual = 0;  ///< Final relative residual, in the norm of the solver's stopping criterion
  Timings seconds;
};

/// Potential on a grid: value[j * nx + i] is the potential at the cell centre ((i + 0.5) h, (j + 0.5) h). At centres
/// inside a conductor it is the conductor's potential.
struct Field {
  int nx = 0, ny = 0;
  double h = 0;               ///< Cell edge (m)
  std::vector<double> value;  ///< Potential (V)
  std::vector<int> body;      ///< Index of the body that contains the centre, -1 in the fluid
};

/// Interface of all solvers of LaplaceProblem. Solvers may keep data that accelerate the next solve of a similar
/// problem, such as buffers and the last solution as initial guess.
class LaplaceSolver {
 public:
  virtual ~LaplaceSolver() = default;
  /// Solves the problem: computes potentials, charges, forces and energy. Throws the exceptions of
  /// LaplaceProblem::check. Throws InputError for a problem that the method does not support, Failure if the iteration
  /// does not converge.
  virtual LaplaceSolution solve(const LaplaceProblem& problem) = 0;
  /// Returns the potential of the last solve on a grid. Throws Failure if no solution is stored.
  virtual Field field() const = 0;
  /// Discards the solutions of earlier solves, so that the initial guess of the next solve depends on its problem only.
  virtual void forget() = 0;
};

/// Computes the capacitance matrix C [groups x groups], row-major (F/m). C_ij is the charge on group i with group j at
/// 1 V, and every other group and electrode side at 0 V (Stephenson 2018, D 6.20). Couplings are ignored. In a box
/// without an electrode the rows sum to zero. Throws the exceptions of `solver`.
std::vector<double> capacitance_matrix(LaplaceSolver& solver, const LaplaceProblem& problem);

}  // namespace lichtenberg::laplace
