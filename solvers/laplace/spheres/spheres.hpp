#pragma once

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "solvers/geometry/box.hpp"
#include "solvers/laplace/problem.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Conducting or dielectric sphere. A conductor has the potential of its group (spheres at one potential, which need
/// not touch). A dielectric has a finite relative permittivity and a uniformly distributed charge; it is the only
/// sphere of its floating group.
struct Sphere {
  Vec3 centre;        ///< Centre (m)
  double radius = 0;  ///< Radius (m)
  int group = 0;      ///< Index of the group
  /// Permittivity relative to the permittivity outside; infinite for a conductor.
  double relative_permittivity = std::numeric_limits<double>::infinity();

  bool is_conductor() const { return relative_permittivity == std::numeric_limits<double>::infinity(); }
};

/// Largest permitted overlap of two spheres in contact, or of a sphere with an insulating side, over the smaller
/// radius.
inline constexpr double deepest_contact = 0.01;

/// Boundary value problem of electrostatics in space: Laplace's equation div(eps grad V) = 0 outside conducting
/// spheres, and inside dielectric ones. The domain is the box [0, lengths] or free space, where V tends to 0 (or to the
/// potential of a uniform field). Unlike in `LaplaceProblem`, nothing is per metre of depth: `Group::charge` is in C,
/// energies are in J.
struct SphereProblem {
  /// Box with sides in the order of `side_names`: x = 0, x = lengths.x, y = 0, ... A wall is insulating; an electrode
  /// has the potential `side_potential`. Ignored in free space.
  Box<3> box;
  std::array<double, 6> side_potential{};  ///< Potential (V) of the electrodes
  bool free_space = false;
  Vec3 uniform_field{};     ///< Field E (V/m) at infinity in free space, of potential -E.r; ignored in a box
  double permittivity = 0;  ///< Permittivity (F/m); required
  std::vector<Sphere> spheres;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< Lumped capacitances between groups, as in LaplaceProblem but in F
  int movable = -1;                 ///< Number of leading spheres whose forces count in measures of accuracy; -1: all

  /// Returns true if an electrode side, or infinity in free space (where V is 0), absorbs the remaining charge.
  bool grounded() const;
  /// Returns true if the problem determines the level of the potential: grounded(), or a sphere has a given potential
  /// or is coupled to such a group. Otherwise the charges must sum to zero, unless all sides are periodic.
  bool has_ground() const;
  /// Returns the sum of the charges (C) that a uniform background neutralizes, in a box that is periodic along all axes
  /// and has no ground; otherwise 0. With a background the mean potential over the box is 0.
  double neutralized_charge() const;
  /// Checks the problem; throws InputError unless all of this holds. All numbers are finite; lengths, radii and the
  /// permittivity are positive. An axis is periodic on both sides or on none. Conductors do not touch or cross
  /// electrode sides. Dielectrics cross electrode sides by at most 0.5 % of their radius, so that they overlap their
  /// images by as much as each other. Spheres cross insulating sides by at most 1 %. Each sphere has a group. A
  /// coupling joins two different groups and has a finite capacitance of at least 0. A floating group has a sphere, or
  /// is coupled to a group with a sphere. Conductors of different groups do not touch; other spheres overlap by at most
  /// 1 % of the smaller radius. A dielectric is alone in a floating group and has a relative permittivity above 1.
  /// Without ground the charges sum to zero, or all sides are periodic.
  void check() const;
};

/// Size of a solve, known before its iteration.
struct SphereForecast {
  int least_degree = 0, largest_degree = 0;  ///< Lowest and highest degree of a sphere's harmonics
  long unknowns = 0;                         ///< Number of unknowns
};

/// Results of a field solve for spheres.
struct SphereSolution {
  /// Potential (V) of each group; if nothing fixes the level, the mean over the spheres is 0,
  /// or with a background that over the box. For a dielectric: the
  /// mean over its surface.
  std::vector<double> group_potential;
  std::vector<double> sphere_charge;  ///< Charge (C) of each sphere
  std::vector<Vec3> sphere_dipole;    ///< Dipole moment (C m) of each sphere: integral of sigma (x - centre)
  std::vector<Vec3> sphere_force;     ///< Force (N) on each sphere; of a conductor: eps/2 integral of E^2 n
  /// Charge (C) of each electrode side; NaN if electrodes meet at an edge, because then only their sum is known.
  std::array<double, 6> side_charge{};
  double electrode_charge = 0;  ///< Charge (C) of all electrodes together
  /// Charge (C) through each coupling from a to b. Charges of floating groups balance to the rounding of the largest
  /// possible charge through a coupling.
  std::vector<double> coupling_charge;
  /// Energy (J): half of the sum of charge times potential, eps/2 integral of E^2. In a uniform field half of the
  /// energy of the surface charges in that field is added, so that a neutral sphere of dipole p has -p.E/2.
  double energy = 0;
  double residual = 0;  ///< Residual of the iteration, relative to the right-hand side and the given charges
  int degree = 0;       ///< Degree of the highest harmonic on any sphere
  long unknowns = 0;    ///< Number of unknowns
  int iterations = 0;   ///< Conjugate gradient iterations
  Timings seconds;
};

/// Potential and field at a point. Inside a sphere, also a dielectric one, it contains the group's potential and zero
/// field.
struct PointField {
  double potential = 0;  ///< Potential (V)
  Vec3 field;            ///< Field (V/m), -grad V
  int sphere = -1;       ///< Sphere that contains the point, -1: none
};

/// Options of SphereSolver.
struct SphereOptions {
  /// Target for the errors of potentials, charges and forces, relative to the largest potential difference, charge and
  /// force; 1e-12 to 0.1. Degrees are raised if forces nearly cancel. Errors of forces can exceed the target if the
  /// largest degree does not suffice; solve_to_accuracy() in accuracy.hpp measures and bounds the error.
  double accuracy = 1e-3;
  /// Degree of the harmonics on all spheres, 1 to 200, without close-pair corrections; 0: chosen from the accuracy.
  int degree = 0;
};

/// Field solver for conducting and dielectric spheres by multipole expansions in solid harmonics about each centre
/// (docs/numerics/spheres.md). The degrees follow from the accuracy and from the neighbours of each sphere. Electrodes
/// of different potential that meet at an edge are not supported.
/// The solver keeps data for the next solve; positions, charges and groups may change between solves. The initial guess
/// is a linear combination of the last solutions. The preconditioner is used again until a sphere has moved by its
/// radius.
class SphereSolver {
 public:
  /// Makes a solver that uses the threads of `team`, which must outlive it; results have identical bits for any number
  /// of threads. Throws InputError for an accuracy or a degree out of range.
  explicit SphereSolver(SphereOptions options = {}, parallel::Team& team = parallel::Team::single());
  /// Makes a solver that owns its team of threads. Throws InputError for an accuracy or a degree out of range.
  SphereSolver(SphereOptions options, std::unique_ptr<parallel::Team> team);
  ~SphereSolver();
  SphereSolver(SphereSolver&&) noexcept;

  /// Solves the problem: computes potentials, charges, dipoles, forces and energy. Throws the exceptions of
  /// SphereProblem::check. Throws InputError if electrode sides have different potentials and are not two opposite
  /// sides, or if the accuracy needs a degree above 200. Throws Failure if the iteration does not converge, or if a gap
  /// is too narrow for the accuracy.
  SphereSolution solve(const SphereProblem& problem);
  /// Computes the degrees and the number of unknowns of a solve, without its iteration. Throws the exceptions that
  /// solve() throws before it iterates.
  SphereForecast forecast(const SphereProblem& problem) const;
  /// Computes potential and field of the last solve at the given points (m). Throws Failure if no solution is stored.
  /// Also throws Failure if the solve used a Reflection (reflections.hpp), for a sphere next to a much larger one.
  std::vector<PointField> field(std::span<const Vec3> points) const;
  /// Computes the capacitance matrix C [groups x groups], row-major (F). C_ij is the charge on group i with group j at
  /// 1 V, and all other groups and the electrodes at 0. Couplings are ignored. In a box without electrodes its rows sum
  /// to zero. Throws the exceptions of solve(), and InputError for dielectric spheres.
  std::vector<double> capacitance_matrix(const SphereProblem& problem);
  /// Discards all kept data, so that the next solve depends on its problem only.
  void forget();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg::laplace
