#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/effects/extrapolated_field.hpp"
#include "src/effects/floating_spheres.hpp"
#include "src/effects/groups.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct FloatingConductorsOptions {
  static const EffectKind& kind();
};

/// Returns the plane field problem (Laplace's equation) of a scene's conductors at their current positions. Bodies: the
/// conductors in order, then the electrodes. Groups: first the equipotential groups in ascending order of id. Then
/// follows one group for each electrode without a series resistor, then one for each potential source at a resistor.
/// Charges and lumped capacitances are per metre of depth.
laplace::LaplaceProblem make_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                             const NodeCharges& charges = {});

/// A plane field problem whose memory is reused for the next problem.
struct ProblemBuffer {
  laplace::LaplaceProblem problem;
  NodeGroups nodes;  ///< only `group_of_node` is valid: the groups are in `problem`
};

/// Writes the field problem of make_laplace_problem() to `buffer` and reuses the memory there.
void fill_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                          const NodeCharges& charges, ProblemBuffer& buffer);

/// Returns the field method that a scene's [field] table selects; null if the method is still to be chosen for an
/// accuracy.
const FieldMethodKind* method_of(const FieldTable& table);

/// Throws InputError if a field method does not support the device (CPU or GPU). `method`: null if it is still to be
/// chosen, which allows any device.
void check_device(FieldDevice device, const FieldMethodKind* method);

/// Throws InputError if the field method of the scene does not support the device that the scene requests. Has no
/// effect for a scene without a field.
void check_device(const Scene& scene);

/// Makes the plane field solver that the options select, with FieldOptions::tolerance. Throws InputError for a device
/// that the method does not support, or that is missing.
std::unique_ptr<laplace::LaplaceSolver> make_field_solver(const FieldOptions& options);

/// Returns the number of cells along the longer side of the predictor's grid. The predictor is a coarser field solver
/// that gives forces between field solves (docs/numerics/coupling.md). The number is that of the field's grid, halved
/// as long as the smallest radius then has at least 1.9 cells. Returns 0 for no predictor: if the scene disables it or
/// has a circuit, or if its method or integrator has none. Also returns 0 if the predictor's grid would not be at least
/// four times as coarse.
int predictor_cells(const Scene& scene);

/// Returns true if the scene's integrator solves the field inside its error control, so that field errors must be
/// negligible.
bool is_inside_integrator(const Scene& scene);

/// Throws InputError if the field method of the scene is not valid for its moving conductors. The multipole method
/// cannot solve disks that overlap or leave the domain. It therefore requires effects.hertz_contact and
/// effects.wall_contact.
void check_can_move(const Scene& scene);

/// Checks a run on several processes (mpirun), which support only field methods that share a solve. Throws InputError
/// if there are several processes and `field` selects another method, or the multigrid on a device. `field`: null if no
/// field is solved, which also requires one process.
void check_processes(const FieldTable* field);

/// Effect of the electric field between floating conductors, which have given charges and unknown potentials (Laplace's
/// equation). It owns the field solver. A field solve dominates the cost of a step, so forces are extrapolated in time
/// between solves. add_forces() adds the extrapolated forces, which the caller updates (follow()).
class FloatingConductors : public Effect {
 public:
  FloatingConductors(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);  ///< two dimensions
  FloatingConductors(const Scene& scene, laplace::SphereSolver solver);                    ///< three dimensions

  const EffectKind& kind() const override { return FloatingConductorsOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
  void add_forces(const State& state, std::span<double> force) const override;
  /// Marks no body, because extrapolated forces are linear in time and the motion has a closed form.
  void mark_interacting(const Bodies&, std::span<const double>, std::vector<bool>&) const override {}

  /// Solves the field for the positions of the bodies, their equipotential groups and charges. Throws Failure for a
  /// conductor whose centre is outside the domain, and the exceptions of the solver. Throws Failure (InputError before
  /// the first solve) if surfaces of different potential touch in a scene without contact_discharge. In three
  /// dimensions the same holds for overlaps of more than 1 % of a radius.
  Electrostatics solve(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);

  /// Sets the predictor, a solver of the same field problems on a coarser grid, which predict() uses. It is not allowed
  /// in a scene with a circuit.
  void set_predictor(std::unique_ptr<laplace::LaplaceSolver> predictor) { predictor_ = std::move(predictor); }
  laplace::LaplaceSolver* predictor() { return predictor_.get(); }
  /// Approximates solve() at a fraction of its cost: the solution on the predictor's coarse grid plus the difference
  /// that the last correct() stored (defect correction). Differences of forces are reduced where the forces have become
  /// smaller. Throws the exceptions of solve(). Two dimensions only.
  Electrostatics predict(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);
  /// Stores the difference of `solved` from the solution on the predictor's grid in the last predict(). `solved`:
  /// result of solve() for the problem of that predict().
  void correct(const Electrostatics& solved);
  /// Discards earlier solutions, from which the initial guesses of the next solves would follow.
  void forget();

  /// Returns the field problem of the last solve() in two dimensions, for error checks; empty unless the scene requests
  /// an accuracy.
  const std::optional<laplace::LaplaceProblem>& last_problem() const { return last_problem_; }
  /// Sets the extrapolated forces that add_forces() adds. `extrapolated` must outlive this object.
  void follow(const ExtrapolatedField& extrapolated) { extrapolated_ = &extrapolated; }

  laplace::LaplaceSolver* solver() { return solver_.get(); }  ///< plane field solver; null in three dimensions
  std::int64_t solves() const { return solves_; }
  std::int64_t iterations() const { return iterations_; }  ///< linear-solver iterations of all solves
  std::int64_t predictions() const { return predictions_; }
  void set_counters(std::int64_t solves, std::int64_t iterations, std::int64_t predictions) {
    solves_ = solves, iterations_ = iterations, predictions_ = predictions;
  }

 private:
  void check(const Bodies& bodies, const ElectricalGroups& groups) const;
  Electrostatics solve_in_space(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);
  void fill_problem(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges,
                    ProblemBuffer& buffer) const;
  Electrostatics in_si(const ProblemBuffer& buffer, const laplace::LaplaceSolution& solution,
                       const ElectricalGroups& groups, const NodeCharges& charges) const;
  Electrostatics conductor_results(const ProblemBuffer& buffer, const laplace::LaplaceSolution& solution) const;
  void check_contacts(const Bodies& bodies, const ElectricalGroups& groups) const;

  Scene scene_;
  std::unique_ptr<laplace::LaplaceSolver> solver_, predictor_;  ///< null: none
  std::optional<laplace::SphereSolver> spheres_;                ///< used instead of solver_ in three dimensions
  std::vector<Terminal> terminals_;
  ProblemBuffer problem_, predicted_problem_;  ///< problems of the last solve and prediction
  laplace::LaplaceSolution coarse_;            ///< predictor's last solution
  Electrostatics correction_;                  ///< solve() minus the predictor's result at the last correct()
  /// Magnitudes (N) of the predictor's forces at the last correct()
  std::vector<double> corrected_norm_;
  std::optional<laplace::LaplaceProblem> last_problem_;
  const ExtrapolatedField* extrapolated_ = nullptr;  ///< null: no forces
  std::int64_t solves_ = 0, iterations_ = 0, predictions_ = 0;
};

/// Makes the effect for a run, with the scene's field solver. In two dimensions it also has a predictor (a solver on a
/// coarser grid) if predictor_cells() is not 0. The solver's tolerance is field.moving_tolerance; for spheres with
/// is_inside_integrator() it is field.tolerance.
std::unique_ptr<FloatingConductors> make_floating_conductors(const Scene& scene);

}  // namespace lichtenberg::effects
