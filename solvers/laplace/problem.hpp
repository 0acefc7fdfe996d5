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
  double potential = 0;  ///< V, of an electrode
  /// If set, the potential along the side, V(p): an electrode whose potential varies. Validation puts the exact
  /// field of an unbounded problem on the walls with it, so that no box error hides the scheme's. Called from several
  /// threads at once.
  std::function<double(Vec2)> profile;

  double potential_at(Vec2 p) const { return profile ? profile(p) : potential; }
};

enum SideIndex { left = 0, right = 1, bottom = 2, top = 3 };

class LinkModel;

/// A perfect conductor: its shape and the group whose potential it has. Bodies of one group need not touch.
struct Body {
  Shape shape;
  int group = 0;
  /// Conductance of the cut-cell method's links to the surface (cutcell/surface_links.hpp); null: a bare conductor's.
  /// Must outlive the problem. Other methods refuse it.
  const LinkModel* link_model = nullptr;
};

/// Bodies that share one potential. Floating: the total charge is given and the potential unknown. Fixed: the
/// potential is given and the charge follows.
struct Group {
  bool floating = true;
  double charge = 0;     ///< C per metre of depth, if floating
  double potential = 0;  ///< V, if fixed
};

/// A link between two groups beside the field: charge capacitance * (V_a - V_b) flows from a to b, so that the charge
/// balance of a floating group is
///
///   Q_field(a) + sum over its couplings of capacitance * (V_a - V_b) = charge of a.
///
/// What charges obey that move through conductances g for a time dt, taken implicitly: dQ_a/dt = J_a - g (V_a - V_b)
/// becomes the balance above with capacitance = dt g and charge = Q_a + dt J_a (D 5.5, with J and Ohm's law). Infinite
/// capacitance is the limit in which a and b are one group (D 5.3), zero that in which they are not coupled. Either may
/// be a fixed group, also one without a body: a supply behind a resistor.
struct Coupling {
  int a = 0, b = 0;        ///< groups
  double capacitance = 0;  ///< F per metre of depth; finite, not negative
};

/// Laplace's equation div(eps grad V) = 0 in the box [0, size.x] x [0, size.y] outside the bodies
/// (D 5.2-5.4; two dimensions, all charges, forces and energies per metre of depth).
struct LaplaceProblem {
  Vec2 size;
  std::array<Side, 4> sides;  ///< by SideIndex
  double permittivity = 0;    ///< F/m; has to be given
  std::vector<Body> bodies;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< between groups; several between the same two add up
  int movable = -1;  ///< forces matter on the first so many bodies; -1: on all. For measures of accuracy alone

  /// Whether an electrode side or a body has a given potential.
  bool has_fixed_conductor() const;
  /// False if nothing that the field reaches, or that is coupled to what it reaches, has a given potential: then the
  /// charges must sum to zero, and the potential is defined up to a constant, chosen such that the groups' potentials,
  /// weighted by their number of bodies, have zero mean.
  bool has_ground() const;
  /// Throws InputError if a body or a coupling names no group, a size or radius is not positive, a capacitance is
  /// negative, a floating group has no body and is coupled to none, or if nothing is grounded and the charges do not
  /// sum to zero.
  void check() const;
};

/// Of each group the set that it is coupled with, named by its first group: those with a chain of couplings between
/// them, each of more than `least` (F/m).
std::vector<int> coupled_sets(const LaplaceProblem& problem, double least = 0);
std::vector<int> coupled_sets(int groups, std::span<const Coupling> couplings, double least = 0);

/// For methods that cannot do couplings: throws InputError if there are any. `method` begins the sentence.
void refuse_couplings(const LaplaceProblem& problem, const std::string& method);

/// For methods that have no links: throws InputError if a body has a link model. `method` begins the sentence.
void refuse_link_models(const LaplaceProblem& problem, const std::string& method);

/// Seconds spent by one solve.
struct Timings {
  double setup = 0;   ///< links, levels, coarse factorization
  double solve = 0;   ///< Krylov or relaxation iterations
  double forces = 0;  ///< charges, forces, energy
};

struct LaplaceSolution {
  std::vector<double> group_potential;  ///< V, a group
  std::vector<double> body_charge;      ///< C/m, a body: that of the field, without what couplings carry
  std::vector<Vec2> body_force;         ///< N/m, a body
  std::array<double, 4> side_charge{};  ///< C/m, charge on each side of the box if it is an electrode
  double energy = 0;                    ///< J/m, eps/2 integral |grad V|^2
  long unknowns = 0;
  int iterations = 0;
  double work = 0;      ///< operator evaluations, in residual evaluations on the whole grid; 0: not counted
  double residual = 0;  ///< final relative residual, in the norm of the solver's stop criterion
  Timings seconds;
};

/// Potential on cell centres: value[j * nx + i] at ((i + 0.5) h, (j + 0.5) h), the conductor's potential inside it.
struct Field {
  int nx = 0, ny = 0;
  double h = 0;               ///< m
  std::vector<double> value;  ///< V
  std::vector<int> body;      ///< index of the body that covers the centre, -1 in the fluid
};

/// What every field solver can do. Solvers keep what speeds up the next call on a similar scene (buffers, the last
/// potentials as first guess); `forget` drops that history, so that the next solve depends on its problem alone.
class LaplaceSolver {
 public:
  virtual ~LaplaceSolver() = default;
  /// Throws InputError for a problem that has no solution, Failure if the iteration does not converge.
  virtual LaplaceSolution solve(const LaplaceProblem& problem) = 0;
  /// The potential of the last solve.
  virtual Field field() const = 0;
  virtual void forget() = 0;
};

/// C (row-major, groups x groups; F/m): charge on group i when group j is at 1 V and every other group and electrode
/// side at 0 V (D 6.20). In a box without any electrode the rows sum to zero.
std::vector<double> capacitance_matrix(LaplaceSolver& solver, const LaplaceProblem& problem);

}  // namespace lichtenberg::laplace
