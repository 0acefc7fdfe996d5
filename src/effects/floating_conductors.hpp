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

/// Returns the field problem of a scene's conductors at their current positions (D 5.2, 5.3). Bodies: the conductors in
/// order, then the electrodes. Groups: the electrical groups in ascending order of id, then one for each electrode
/// without a resistor, then one for each potential source at the end of a resistor. Charges and lumped conductances are
/// converted to values per metre of depth.
laplace::LaplaceProblem make_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                             const NodeCharges& charges = {});

/// A field problem whose memory is reused for the next problem.
struct ProblemBuffer {
  laplace::LaplaceProblem problem;
  NodeGroups nodes;  ///< only `group_of_node` is valid: the groups are in `problem`
};

/// Writes the problem of make_laplace_problem to `buffer`.
void fill_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                          const NodeCharges& charges, ProblemBuffer& buffer);

/// Returns the method of a field; null if it is still to be chosen.
const FieldMethodKind* method_of(const FieldTable& table);

/// Throws InputError for a device that the method does not support; null: method still to be chosen.
void check_device(FieldDevice device, const FieldMethodKind* method);

/// Throws InputError for a device that the scene's method does not support.
void check_device(const Scene& scene);

/// Makes the solver that a scene selects, at the tolerance of a single solve. Throws InputError for a device that the
/// method does not support, or that is missing.
std::unique_ptr<laplace::LaplaceSolver> make_field_solver(const FieldOptions& options);

/// Returns the number of cells along the longer side of the predictor's grid, which gives forces between field solves
/// (docs/numerics/coupling.md). It is the number of the field's grid, halved while the smallest radius has at least 1.9
/// cells. 0: no predictor, because the scene disables it or has a circuit, or because its grid is not at least four
/// times as coarse.
int predictor_cells(const Scene& scene);

/// Returns true if field solves are inside an integrator's error control, where field errors must be negligible.
bool is_inside_integrator(const Scene& scene);

/// Throws InputError if the method cannot follow the scene's conductors. The multipole method cannot solve disks that
/// overlap or leave the domain, which only contact forces prevent.
void check_can_move(const Scene& scene);

/// Checks parallel processes (mpirun), which support assembled field solves only. Throws InputError if there are
/// several and `field` selects another solver; null: no field is solved.
void check_processes(const FieldTable* field);

/// Electrostatics of conductors with given charges (D 5.3). Owns the field solver. Because a field solve dominates the
/// cost of a step, forces are extrapolated between solves: add_forces adds the forces of an ExtrapolatedField, which
/// the caller updates.
class FloatingConductors : public Effect {
 public:
  FloatingConductors(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);  ///< two dimensions
  FloatingConductors(const Scene& scene, laplace::SphereSolver solver);                    ///< three dimensions

  const EffectKind& kind() const override { return FloatingConductorsOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
  void add_forces(const State& state, std::span<double> force) const override;
  /// Extrapolated forces are linear in time, so free flight has a closed form and no body is marked.
  void mark_interacting(const Bodies&, std::span<const double>, std::vector<bool>&) const override {}

  /// Solves the field. Throws the exceptions of the solver. Throws Failure (InputError before the first solve) for a
  /// conductor outside the domain, or for one that touches another potential in a scene without contact_discharge.
  Electrostatics solve(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);

  /// Sets the predictor, a solver of the same problems on a coarser grid, which enables predict(). Not allowed in a
  /// scene with a circuit.
  void set_predictor(std::unique_ptr<laplace::LaplaceSolver> predictor) { predictor_ = std::move(predictor); }
  laplace::LaplaceSolver* predictor() { return predictor_.get(); }
  /// Approximates solve() at a fraction of its cost: the predictor's solution plus its error at the last correct().
  /// Throws the exceptions of solve().
  Electrostatics predict(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);
  /// Stores the predictor's error; `solved` is the result of solve() for the last prediction's problem.
  void correct(const Electrostatics& solved);
  /// Makes the solvers' next solves independent of earlier ones.
  void forget();

  /// Returns the last solved problem, for error checks, if the scene specifies an accuracy.
  const std::optional<laplace::LaplaceProblem>& last_problem() const { return last_problem_; }
  /// Sets the forces that add_forces() adds, at any time. `extrapolated` must outlive this object.
  void follow(const ExtrapolatedField& extrapolated) { extrapolated_ = &extrapolated; }

  laplace::LaplaceSolver* solver() { return solver_.get(); }  ///< null in three dimensions
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
  Electrostatics correction_;                  ///< correction of coarse_
  /// N, magnitudes of the predictor's forces at the last correction
  std::vector<double> corrected_norm_;
  std::optional<laplace::LaplaceProblem> last_problem_;
  const ExtrapolatedField* extrapolated_ = nullptr;  ///< null: no forces
  std::int64_t solves_ = 0, iterations_ = 0, predictions_ = 0;
};

/// Makes the effect with the scene's solver at the tolerance of a moving scene, and with a predictor if it has one.
std::unique_ptr<FloatingConductors> make_floating_conductors(const Scene& scene);

}  // namespace lichtenberg::effects
