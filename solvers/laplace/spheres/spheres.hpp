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

/// Sphere: its position and the group whose potential it has. Spheres of one group need not touch. A sphere of finite
/// relative permittivity is a dielectric, the only member of its floating group, with a uniformly distributed charge.
struct Sphere {
  Vec3 centre;        ///< Centre (m)
  double radius = 0;  ///< Radius (m)
  int group = 0;
  double relative_permittivity =
      std::numeric_limits<double>::infinity();  ///< Permittivity relative to that outside; infinite for a conductor

  bool is_conductor() const { return relative_permittivity == std::numeric_limits<double>::infinity(); }
};

/// Largest overlap of two spheres, and of a sphere and an insulating side, over the smaller radius; contacts overlap.
inline constexpr double deepest_contact = 0.01;

/// Laplace's equation div(eps grad V) = 0 outside conducting and in dielectric spheres, in the box [0, lengths] or in
/// free space, where V tends to 0. Unlike in `LaplaceProblem`, nothing is per metre of depth: `Group::charge` is in C,
/// energies are in J.
struct SphereProblem {
  /// Box with sides in the order of `side_names`: x = 0, x = lengths.x, y = 0, ... A wall is insulating, an electrode
  /// has its potential below, and a periodic axis is periodic on both sides. Ignored in free space.
  Box<3> box;
  std::array<double, 6> side_potential{};  ///< Potential (V) of the electrodes
  bool free_space = false;
  Vec3 uniform_field{};     ///< Field (V/m) at infinity in free space
  double permittivity = 0;  ///< Permittivity (F/m); required
  std::vector<Sphere> spheres;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< As in LaplaceProblem, with capacitances in F
  int movable = -1;                 ///< As in LaplaceProblem, for spheres

  /// Returns true if an electrode, or infinity in free space (where V is 0), absorbs the remaining charge.
  bool grounded() const;
  /// Returns true if grounded(), or if a sphere has a given potential or is coupled to one; otherwise charges must sum
  /// to zero.
  bool has_ground() const;
  /// Throws InputError for an invalid problem. Lengths, radii and the permittivity must be positive. An axis must be
  /// periodic on both sides or on none. A sphere must not be on or through another side, except for contacts with
  /// insulating sides (deepest_contact). Each sphere needs a group. A coupling must join two groups and have a finite
  /// capacitance of at least 0. A floating group needs a sphere, or a coupling to a group with one. Conductors of
  /// different groups must not touch. Other spheres may overlap by at most 1 % of the smaller radius. A dielectric must
  /// be alone in a floating group and have a relative permittivity above 1. Without ground the charges must sum to
  /// zero.
  void check() const;
};

/// Size of a solve, estimated from its set-up alone.
struct SphereForecast {
  int least_degree = 0, largest_degree = 0;  ///< Degrees of the spheres' harmonics
  long unknowns = 0;
};

struct SphereSolution {
  /// Potential (V) of each group; if nothing fixes the level, the mean over the spheres is 0. For a dielectric: the
  /// mean over its surface.
  std::vector<double> group_potential;
  std::vector<double> sphere_charge;  ///< Charge (C) of each sphere
  std::vector<Vec3> sphere_dipole;    ///< Dipole moment (C m) of each sphere: integral of sigma (x - centre)
  std::vector<Vec3> sphere_force;     ///< Force (N) on each sphere: eps/2 integral of E^2 n
  /// Charge (C) of each electrode; not a number if electrodes meet at an edge, where only the sum is known.
  std::array<double, 6> side_charge{};
  double electrode_charge = 0;  ///< Charge (C) of all electrodes together
  /// Charge (C) through each coupling from a to b. Charges of floating groups balance to the rounding of the largest
  /// possible charge through a coupling.
  std::vector<double> coupling_charge;
  double energy = 0;    ///< Energy (J), eps/2 integral of E^2: half of the sum of charge times potential
  double residual = 0;  ///< Residual of the iteration, relative to the right-hand side and the given charges
  int degree = 0;       ///< Degree of the highest harmonic on any sphere
  long unknowns = 0;
  int iterations = 0;
  Timings seconds;
};

/// Potential and field at a point; inside a sphere its potential and zero field.
struct PointField {
  double potential = 0;  ///< Potential (V)
  Vec3 field;            ///< Field (V/m), -grad V
  int sphere = -1;       ///< Sphere that contains the point, -1: none
};

struct SphereOptions {
  /// Target for the errors of potentials, charges and forces, relative to the largest potential difference, charge and
  /// force; 1e-12 to 0.1. Errors exceed it several times if forces nearly cancel; solve_to_accuracy (accuracy.hpp)
  /// measures and bounds the error.
  double accuracy = 1e-3;
  /// Degree of the harmonics on all spheres, up to 200, without close-pair corrections; 0: from the accuracy
  int degree = 0;
};

/// Solver for conducting and dielectric spheres by solid harmonics on each (docs/numerics/spheres.md).
/// Degrees follow from the accuracy and the neighbours of each sphere. Electrodes of different potential that meet at
/// an edge are not supported. The solver keeps data for the next solve of a similar scene. The initial guess is a
/// linear combination of the last solutions. The preconditioner serves until a sphere has moved by its radius. The
/// scene may move, be charged and regroup between solves.
class SphereSolver {
 public:
  /// Makes a solver. Throws InputError for an accuracy or a degree out of range. `team` must outlive the solver;
  /// results are bitwise identical for any number of threads.
  explicit SphereSolver(SphereOptions options = {}, parallel::Team& team = parallel::Team::single());
  /// Makes a solver that owns its team. Throws InputError for an accuracy or a degree out of range.
  SphereSolver(SphereOptions options, std::unique_ptr<parallel::Team> team);
  ~SphereSolver();
  SphereSolver(SphereSolver&&) noexcept;

  /// Solves the problem. Throws the exceptions of SphereProblem::check. Throws InputError if electrode sides differ in
  /// potential and are not two opposite sides. Throws InputError if the accuracy needs a degree beyond double precision
  /// or memory. Throws Failure if the iteration does not converge, or if a gap is too narrow for the accuracy.
  SphereSolution solve(const SphereProblem& problem);
  /// Estimates the size of a solve. Throws the exceptions that solve throws before it iterates.
  SphereForecast forecast(const SphereProblem& problem) const;
  /// Returns potential and field of the last solve at the points. Throws Failure if nothing has been solved, or if the
  /// scene has a Reflection (reflections.hpp), i.e. a sphere that is much larger than its neighbour.
  std::vector<PointField> field(std::span<const Vec3> points) const;
  /// Returns the capacitance matrix C (row-major, groups x groups; F): charge on group i with group j at 1 V, all other
  /// groups and the electrodes at 0. If nothing is grounded its rows sum to zero. Throws the exceptions of solve().
  std::vector<double> capacitance_matrix(const SphereProblem& problem);
  /// Discards all kept data, so that the next solve depends on its problem only.
  void forget();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg::laplace
