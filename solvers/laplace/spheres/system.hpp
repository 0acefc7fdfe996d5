#pragma once

#include <memory>
#include <optional>
#include <span>

#include "solvers/laplace/spheres/cell_field.hpp"
#include "solvers/laplace/spheres/charge_constraints.hpp"
#include "solvers/laplace/spheres/charges_and_dipoles.hpp"
#include "solvers/laplace/spheres/close_pairs.hpp"
#include "solvers/laplace/spheres/far_field.hpp"
#include "solvers/laplace/spheres/initial_guess.hpp"
#include "solvers/laplace/spheres/reflections.hpp"

namespace lichtenberg::laplace::spheres {

/// Potential in the domain without spheres. In a box it is due to the electrode sides: constant, or linear along one
/// axis. In free space it is the potential of the uniform field.
struct WallPotential {
  /// Computes the potential of a problem. Throws InputError if electrode sides have different potentials and are not
  /// two opposite sides.
  explicit WallPotential(const SphereProblem& problem);
  double constant = 0;  ///< Potential at the origin (V)
  Vec3 slope;           ///< Gradient of the potential (V/m)
  int axis = -1;        ///< Axis of the box along which the potential is linear; -1: none
  /// Returns the potential (V) at p (m).
  double at(Vec3 p) const { return constant + dot(slope, p); }
};

struct ResponseMultipoles;

/// Share of the accuracy for errors of forces due to the truncation of harmonics. The residual of the iteration uses a
/// part of the rest (solver.cpp).
inline constexpr double truncation_share = 0.5;

/// Fields of the spheres' multipoles, at the spheres and at points. Near spheres and images act directly (NearField).
/// All others act by Ewald sums for each pair (FarField, up to 48 spheres) or between cells (CellField).
class Fields {
 public:
  /// Chooses the degrees of the spheres' harmonics for the accuracy times `share`, unless the options give a degree,
  /// and prepares all tables for the accuracy. `past`: earlier fields whose tables are used again if possible. Throws
  /// InputError if a required degree is too large, and the exceptions of close_pairs().
  Fields(const SphereProblem& problem, const Mirrors& mirrors, const SphereOptions& options, double share,
         const Fields* past, parallel::Team& team);

  const std::vector<Site>& sites() const { return sites_; }                    ///< Spheres with their degrees
  const std::vector<ClosePair>& close_pairs() const { return close_pairs_; }   ///< Narrow gaps with corrections
  const std::vector<Reflection>& reflections() const { return reflections_; }  ///< Small spheres next to large ones
  double accuracy() const { return accuracy_; }  ///< Accuracy for which the degrees were chosen
  /// Returns the size of the last harmonics that the degrees of touching conductors permit, in units of the first.
  double last_harmonics() const;
  double narrowness() const { return narrowness_; }  ///< Smallest factor for narrow gaps (close_pairs.hpp)
  /// Adds the field of the `multipoles` a_lm (V) of all spheres, except each sphere's own field, to the `local`
  /// coefficients b_lm (V). Both arrays are [site][harmonic].
  void add(const double* multipoles, double* local, parallel::Team& team) const;
  /// Adds the field of all spheres, except each sphere's own field, to the `local` coefficients (V) for eight sets of
  /// `multipoles` (V) at once. Each array element contains the eight values of a coefficient.
  void add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const;
  /// Computes the local coefficients (V) of the field, up to one degree above the sites' own, [site][harmonic].
  /// Reflections are not included.
  std::vector<double> one_degree_beyond(const double* multipoles, parallel::Team& team) const;
  /// Returns true if SphereOptions::degree is given, so that all spheres have this degree.
  bool has_fixed_degree() const { return fixed_degree_ > 0; }
  /// Adds the field of the multipoles at points: 4 local coefficients (V) per point, the potential and `unit` times its
  /// gradient (y, z, x). Close-pair corrections and reflections are not included. `unit`: any small length (m).
  void add_at(std::span<const Vec3> points, double unit, const double* multipoles, double* local,
              parallel::Team& team) const;
  /// Returns the coarse equations for the preconditioner, null if they do not save time or are not positive definite.
  /// `past`: coarse equations of an earlier solve, used again if possible.
  std::shared_ptr<const ChargesAndDipoles> charges_and_dipoles(std::shared_ptr<const ChargesAndDipoles> past,
                                                               parallel::Team& team) const;

 private:
  std::vector<NearPair> near_pairs(const std::vector<Site>& targets, parallel::Team& team) const;
  FarImages far_images(double target_radius, double accuracy) const;
  void choose_degrees(const SphereProblem& problem, const std::vector<NearPair>& pairs, parallel::Team& team);
  /// Degree that the neighbours of a sphere require.
  struct RequiredDegree {
    double degree = 0;
    double possible = 0;  ///< Accuracy for which the largest degree suffices
    void raise(double to, double possible_then);
  };
  void choose_reflecting(const SphereProblem& problem, const std::vector<NearPair>& lopsided,
                         std::vector<RequiredDegree>& required);
  std::vector<NearPair> narrow_gaps(const SphereProblem& problem, const std::vector<NearPair>& pairs,
                                    const std::vector<NearPair>& lopsided, std::vector<RequiredDegree>& required);
  void set_degrees(const std::vector<RequiredDegree>& required);
  template <class T>
  void add_reflections(const T* multipoles, T* local) const;
  bool suffices_for(const NearPair& pair) const;

  Mirrors mirrors_;
  double accuracy_;
  int fixed_degree_;  ///< Fixed degree; 0: none
  std::vector<Site> sites_;
  std::vector<ClosePair> close_pairs_;
  std::vector<Reflection> reflections_;
  double narrowness_ = 1;
  double range_ = 0;  ///< Distance (length) up to which images act directly if there are no cells; 0: none does
  std::unique_ptr<Cells> cells_;
  std::unique_ptr<NearField> near_;
  std::unique_ptr<FarField> far_;
  std::shared_ptr<const CellConvolution> convolution_;
  std::unique_ptr<CellField> cell_field_;
};

/// Linear system for the multipoles a_lm of all spheres, given by its matrix-vector product. b_lm are the local
/// coefficients of the field of all other charges. On a conductor at potential phi the boundary condition is a_lm +
/// b_lm = phi delta_l0 (docs/numerics/spheres.md).
/// The unknowns are x = sqrt(R) a with the radius R. The operator x + sqrt(R) b is then symmetric, and positive because
/// the energy of the charges on the spheres is 2 pi eps x.(x + sqrt(R) b). A fixed group has a given potential, a
/// floating group a given charge. Conjugate gradients iterate among the x that keep given charges; the groups'
/// potentials are Lagrange multipliers (charge_constraints.hpp).
/// On a dielectric a = -beta b for l > 0, with beta = (k - 1) l / ((k + 1) l + 1) for the relative permittivity k.
/// There x = sqrt(R / beta) a; on a conductor beta is 1.
class System {
 public:
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  /// Sets up the system of a problem. `past`: system of an earlier solve whose tables are used again if possible, or
  /// null. `share`: factor of the accuracy for the degrees.
  System(const SphereProblem& problem, const SphereOptions& options, parallel::Team& team, const System* past,
         double share = 1);

  /// Returns the number of unknowns: harmonics of all spheres, one amplitude per close pair, one unknown per coupling.
  int size() const { return first_coupling() + constraints_.coupling_count(); }
  /// Computes y, the product of the system's matrix with x. For harmonics y = x + sqrt(R beta) b: R is the sphere's
  /// radius, beta a factor of its permittivity (1 for a conductor). b are the local coefficients of the field of all
  /// other charges. `T`: double, or Lanes for eight x at once.
  template <class T>
  void apply(const T* x, T* y) const;
  /// Projects x orthogonally: removes the part that changes the given charges of groups.
  void project(double* x) const { constraints_.project(x); }
  /// Applies the preconditioner: replaces x by an approximate solution of apply(solution) = x that contributes nothing
  /// to given charges.
  void precondition(double* x) const;
  /// Corrects rounding errors of the given charges in x.
  void enforce_charges(double* x) const { constraints_.enforce_charges(x); }
  /// Makes an initial guess with the given charges: a corrected linear combination of past solutions, if there are any.
  /// `noise`: relative error of past solutions.
  std::vector<double> start(const History& history = {}, double noise = 0) const;
  /// Computes the right-hand side of apply(x). It is sqrt(R) (fixed potential - potential without spheres) for l = 0,
  /// and R sqrt(R beta) times the field without spheres for l = 1. For a coupling (lumped capacitance C between groups
  /// a and b) it is sqrt(C') (V_a - V_b), with C' = C / (4 pi eps). Potentials of floating groups count as 0.
  std::vector<double> right_hand_side() const;
  /// Returns the right-hand side for one group at 1 V and all else at 0.
  std::vector<double> unit_potential(int group) const;
  /// Computes the charge of each group over 4 pi eps from x: the scalar products with unit_potential().
  std::vector<double> group_charges(const double* x) const;
  /// Computes potentials, charges, dipoles, forces and energy from the solution x and its `product` with the matrix.
  SphereSolution results(const std::vector<double>& x, const std::vector<double>& product) const;

  const SphereProblem& problem() const { return problem_; }
  const std::vector<Site>& sites() const { return fields_->sites(); }
  const Fields& fields() const { return *fields_; }
  /// Makes an entry of the history from a solution x and the groups' potentials (V).
  PastSolution past(const std::vector<double>& x, const std::vector<double>& group_potential) const;
  const WallPotential& wall() const { return wall_; }
  /// Computes the multipoles a_lm (V) from the unknowns x, [site][harmonic].
  template <class T>
  std::vector<T> multipoles(const T* x) const;
  /// Returns the amplitude (V) of the corrections of close pair number `pair` from the unknowns x.
  template <class T>
  T amplitude(const T* x, std::size_t pair) const {
    return x[harmonics_size() + pair] / std::sqrt(fields_->close_pairs()[pair].energy);
  }

 private:
  int harmonics_size() const { return start_.back(); }
  /// Returns the ratio of multipoles to unknowns for a sphere's harmonics of degree l: sqrt(beta / R).
  double scale(std::size_t sphere, int l) const;
  int first_coupling() const { return harmonics_size() + static_cast<int>(fields_->close_pairs().size()); }
  template <class T>
  void add_close_pairs(const T* x, const T* multipoles, T* y) const;
  void add_reflected_forces(const double* multipoles, SphereSolution& solution) const;
  void add_correction_forces(const double* x, const double* multipoles, SphereSolution& solution) const;
  ResponseMultipoles response(const std::vector<double>& x, const std::vector<double>& multipoles,
                              const std::vector<double>& missed) const;
  std::vector<double> wall_at_sites() const;
  SolveTarget target(const std::vector<ChargeConstraint>& constraints) const;

  SphereProblem problem_;
  Mirrors mirrors_;
  WallPotential wall_;
  std::shared_ptr<const Fields> fields_;  ///< Shared with the last solve if nothing has moved
  const std::vector<Site>& sites_;
  std::vector<int> start_;
  parallel::Team* team_;
  ChargeConstraints constraints_;
  std::shared_ptr<const ChargesAndDipoles> charges_and_dipoles_;  ///< Null if not used
  std::optional<ConstrainedCharges> coarse_;
};

}  // namespace lichtenberg::laplace::spheres
