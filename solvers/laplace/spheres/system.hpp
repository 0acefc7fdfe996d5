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

/// Potential without spheres. In a box it is that of the sides, constant or linear along one axis; in free space it is
/// that of the uniform field.
struct WallPotential {
  /// Throws InputError if electrode sides differ in potential and are not two opposite sides.
  explicit WallPotential(const SphereProblem& problem);
  double constant = 0;
  Vec3 slope;
  int axis = -1;  ///< Axis of the box along which it is linear; -1: none
  double at(Vec3 p) const { return constant + dot(slope, p); }
};

struct ResponseMultipoles;

/// Fields of the spheres' multipoles at the spheres and at points. Near images act directly. All others act pair by
/// pair for few spheres, otherwise cell by cell.
class Fields {
 public:
  /// Chooses the spheres' degrees unless the options give one. `past`: earlier fields whose tables are used again if
  /// possible. Throws InputError if a required degree is too large, and the exceptions of close_pairs().
  Fields(const SphereProblem& problem, const Mirrors& mirrors, const SphereOptions& options, const Fields* past,
         parallel::Team& team);

  const std::vector<Site>& sites() const { return sites_; }
  const std::vector<ClosePair>& close_pairs() const { return close_pairs_; }
  const std::vector<Reflection>& reflections() const { return reflections_; }
  double narrowness() const { return narrowness_; }  ///< Factor for narrow gaps (close_pairs.hpp)
  void add(const double* multipoles, double* local, parallel::Team& team) const;
  /// Adds eight fields at once, [harmonic][field].
  void add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const;
  /// Returns local coefficients one degree above the sites' own, [site][harmonic].
  std::vector<double> one_degree_beyond(const double* multipoles, parallel::Team& team) const;
  /// Returns true if SphereOptions::degree is given.
  bool has_fixed_degree() const { return fixed_degree_ > 0; }
  /// Adds the field at points: 4 local coefficients per point, in powers of `unit`.
  void add_at(std::span<const Vec3> points, double unit, const double* multipoles, double* local,
              parallel::Team& team) const;
  /// Returns the coarse equations, null if they do not save time. `past`: those of an earlier solve, used again if
  /// possible.
  std::shared_ptr<const ChargesAndDipoles> charges_and_dipoles(std::shared_ptr<const ChargesAndDipoles> past,
                                                               parallel::Team& team) const;

 private:
  std::vector<NearPair> near_pairs(const std::vector<Site>& targets) const;
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

/// Linear system for the multipoles a_lm of all spheres of radius R. b_lm are the local coefficients of the field of
/// all other charges. On a conductor a_lm + b_lm = phi delta_l0 (README.md). With x = sqrt(R) a, the operator x +
/// sqrt(R) b is symmetric. The energy of the charges on the spheres is 2 pi eps x.(x + sqrt(R) b), which is positive. A
/// fixed group has its potential, a floating one its charge. CG iterates among the x that keep given charges; the
/// groups' potentials are the Lagrange multipliers (charge_constraints.hpp). On a dielectric a = -beta b (l > 0), beta
/// = (k - 1) l / ((k + 1) l + 1) for a relative permittivity k, and x = sqrt(R / beta) a; beta is 1 on a conductor.
class System {
 public:
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  System(const SphereProblem& problem, const SphereOptions& options, parallel::Team& team, const System* past);

  /// Number of unknowns: harmonics of all spheres, one amplitude per close pair, one unknown per coupling.
  int size() const { return first_coupling() + constraints_.coupling_count(); }
  /// Applies the operator x -> x + sqrt(R beta) b. `T`: double, or Lanes for eight x at once.
  template <class T>
  void apply(const T* x, T* y) const;
  /// Removes the part that changes given charges.
  void project(double* x) const { constraints_.project(x); }
  /// Replaces x by an approximate inverse image under apply, within the range of project.
  void precondition(double* x) const;
  /// Makes the given charges exact.
  void enforce_charges(double* x) const { constraints_.enforce_charges(x); }
  /// Returns an initial guess with the given charges: a corrected linear combination of past solutions, if any;
  /// `noise`: their relative error.
  std::vector<double> start(const History& history = {}, double noise = 0) const;
  /// Returns the right-hand side of apply(x), up to the floating potentials: sqrt(R) (fixed potential - potential of
  /// the sides), and the fixed potentials at couplings.
  std::vector<double> right_hand_side() const;
  /// Returns the right-hand side for a fixed group at 1 V and all else at 0.
  std::vector<double> unit_potential(int group) const;
  /// Returns the charges of x by group over 4 pi eps: products with unit_potential.
  std::vector<double> group_charges(const double* x) const;
  SphereSolution results(const std::vector<double>& x) const;

  const SphereProblem& problem() const { return problem_; }
  const std::vector<Site>& sites() const { return fields_->sites(); }
  const Fields& fields() const { return *fields_; }
  /// Returns a history entry with a solution and the groups' potentials (V).
  PastSolution past(const std::vector<double>& x, const std::vector<double>& group_potential) const;
  const WallPotential& wall() const { return wall_; }
  /// Returns the multipoles a of x, in the layout of the sites.
  template <class T>
  std::vector<T> multipoles(const T* x) const;
  template <class T>
  T amplitude(const T* x, std::size_t pair) const {
    return x[harmonics_size() + pair] / std::sqrt(fields_->close_pairs()[pair].energy);
  }

 private:
  int harmonics_size() const { return start_.back(); }
  /// Returns a / x of a sphere's harmonics of degree l: sqrt(beta / R).
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
