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

/// A ball: where it is and the group whose potential it has. Spheres of one group need not touch. A ball of finite
/// relative permittivity is a dielectric, alone in its floating group, whose charge is spread evenly on it.
struct Sphere {
  Vec3 centre;        ///< m
  double radius = 0;  ///< m
  int group = 0;
  double relative_permittivity =
      std::numeric_limits<double>::infinity();  ///< over that outside; a conductor's is infinite

  bool is_conductor() const { return relative_permittivity == std::numeric_limits<double>::infinity(); }
};

/// Spheres may overlap by so much of the smaller radius, and reach so far into a side that insulates: contacts do.
inline constexpr double deepest_contact = 0.01;

/// Laplace's equation div(eps grad V) = 0 outside conducting and in dielectric spheres, in the box [0, lengths] or in
/// free space, where V tends to 0. Unlike in `LaplaceProblem` nothing is per metre of depth: `Group::charge` is in C,
/// energies are in J.
struct SphereProblem {
  /// Sides in the order of `side_names`: x = 0, x = lengths.x, y = 0, ... A wall insulates, an electrode has its
  /// potential below, an axis is periodic on both its sides. Not looked at in free space.
  Box<3> box;
  std::array<double, 6> side_potential{};  ///< V, of the electrodes
  bool free_space = false;
  Vec3 uniform_field{};     ///< V/m, far away in free space
  double permittivity = 0;  ///< F/m; has to be given
  std::vector<Sphere> spheres;
  std::vector<Group> groups;
  std::vector<Coupling> couplings;  ///< as in LaplaceProblem, capacitance in F
  int movable = -1;                 ///< as in LaplaceProblem, spheres

  /// Whether an electrode or free space (whose V is 0 far away) takes what charge there is.
  bool grounded() const;
  /// Whether that does, or a sphere has a given potential or is coupled to one: else charges must sum to zero.
  bool has_ground() const;
  /// Throws InputError, with one sentence, for what is no problem: a length, a radius or the permittivity not positive,
  /// an axis periodic on one side only, a sphere on or through a side (periodic axes apart), a sphere of no group, a
  /// floating group of no sphere that is coupled to none with one, a coupling that joins no two groups; spheres of
  /// different groups that touch, or of one group that overlap by more than 1 % of the smaller radius; a dielectric
  /// that is not alone in a floating group or has no permittivity above 1; charges that do not sum to zero without
  /// ground.
  void check() const;
};

/// What a solve would take, from its set-up alone.
struct SphereForecast {
  int least_degree = 0, largest_degree = 0;  ///< of the spheres' harmonics
  long unknowns = 0;
};

struct SphereSolution {
  /// V, a group; where nothing fixes their level the spheres' mean is 0. Of a dielectric the mean over its surface.
  std::vector<double> group_potential;
  std::vector<double> sphere_charge;  ///< C, a sphere
  std::vector<Vec3> sphere_dipole;    ///< C m, a sphere: integral of sigma (x - centre)
  std::vector<Vec3> sphere_force;     ///< N, a sphere: eps/2 integral of E^2 n
  /// C, of each electrode; not a number where electrodes of one box meet at an edge, of which only the sum is known.
  std::array<double, 6> side_charge{};
  double electrode_charge = 0;  ///< C, of all electrodes together
  /// C, through each coupling from a to b. Floating groups balance to rounding of what the strongest one could carry.
  std::vector<double> coupling_charge;
  double energy = 0;    ///< J, eps/2 integral of E^2: 1/2 sum of charge and potential
  double residual = 0;  ///< of the iteration, relative to the right-hand side and the given charges
  int degree = 0;       ///< of the highest harmonic on any sphere
  long unknowns = 0;
  int iterations = 0;
  Timings seconds;
};

/// Potential and field at a point; inside a sphere its potential and no field.
struct PointField {
  double potential = 0;  ///< V
  Vec3 field;            ///< V/m, -grad V
  int sphere = -1;       ///< that covers the point, -1: none
};

struct SphereOptions {
  /// Error of potentials, charges and forces that is aimed at, relative to the largest difference of potentials, charge
  /// and force; 1e-12 to 0.1. Where forces all but cancel it is some times as much: solve_to_accuracy (accuracy.hpp)
  /// measures what comes out and keeps it.
  double accuracy = 1e-3;
  int degree =
      0;  ///< of the harmonics on all spheres, up to 200; 0: what the accuracy takes. Gaps are not treated apart then
};

/// Conducting and dielectric spheres by real solid harmonics on each (README.md). Degrees follow from the accuracy and
/// the neighbours of each sphere. Different potentials of electrodes that meet at an edge are refused. What speeds up
/// the next solve of a similar scene is kept: a mixture of the last solutions is the first guess, and what
/// preconditions serves until a sphere has moved by its radius, so that the scene may move, be charged and regroup.
class SphereSolver {
 public:
  /// Throws InputError for an accuracy or a degree out of range. `team` must outlive the solver; results are the same
  /// bits for any number of threads.
  explicit SphereSolver(SphereOptions options = {}, parallel::Team& team = parallel::Team::single());
  /// Has a team of its own.
  SphereSolver(SphereOptions options, std::unique_ptr<parallel::Team> team);
  ~SphereSolver();
  SphereSolver(SphereSolver&&) noexcept;

  /// Throws InputError as SphereProblem::check does, and where the accuracy would take a degree beyond what double
  /// precision or memory hold (the sentence says which); Failure if the iteration does not converge.
  SphereSolution solve(const SphereProblem& problem);
  /// Throws as solve does before it solves.
  SphereForecast forecast(const SphereProblem& problem) const;
  /// Of the last solve. Throws Failure if nothing has been solved.
  std::vector<PointField> field(std::span<const Vec3> points) const;
  /// C (row-major, groups x groups; F): charge on group i when group j is at 1 V, all other groups and the electrodes
  /// at 0. Where nothing is grounded its rows sum to zero.
  std::vector<double> capacitance_matrix(const SphereProblem& problem);
  /// The next solve depends on its problem alone.
  void forget();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg::laplace
