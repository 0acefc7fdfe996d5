#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/effects/circuit.hpp"
#include "src/effects/electrostatics.hpp"
#include "src/effects/floating_spheres.hpp"
#include "src/effects/groups.hpp"
#include "src/effects/held_field.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::effects {

struct FloatingConductorsOptions {
  static const EffectKind& kind();
};

/// The field problem of a scene's conductors where they are now (D 5.2, 5.3). Bodies: the conductors in order, then the
/// electrodes. Groups: the electrical groups in ascending order of id, then one for each electrode without a resistor,
/// then one for each supply at the end of a resistor. Charges and what resistors carry become those per metre of depth.
laplace::LaplaceProblem make_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                             const NodeCharges& charges = {});

/// A field problem with the memory that the next one is made in.
struct AskedField {
  laplace::LaplaceProblem problem;
  NodeGroups nodes;  ///< `of_node` alone: the groups are the problem's
};

/// Makes the problem of make_laplace_problem in `asked`.
void ask_for_field(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges,
                   AskedField& asked);

/// Null if it is to be chosen.
const FieldMethodKind* method_of(const FieldTable& table);

/// Throws InputError for a device that the method cannot use; null: one is to be chosen.
void check_device(FieldDevice device, const FieldMethodKind* method);

/// Throws InputError for a device that the scene's method cannot use.
void check_device(const Scene& scene);

/// The solver that a scene asks for, at the tolerance of a single solve. Throws InputError for a device that the method
/// cannot use, or that is not there.
std::unique_ptr<laplace::LaplaceSolver> make_field_solver(const FieldOptions& options);

/// Cells along the longer side of the grid on which forces are predicted between field solves (mechanics/README.md):
/// the field's own, halved as long as the smallest radius has two cells. 0: none, because the scene wants none, has a
/// circuit, or its field's grid is not four times as fine.
int predictor_cells(const Scene& scene);

/// Whether the field is solved within an integrator's error control, where its own error must not show.
bool is_inside_integrator(const Scene& scene);

/// Throws InputError if the method cannot follow the scene's conductors where they may move: disks that go through each
/// other or out of the domain, which only contact forces prevent, are beyond the multipole method.
void check_can_move(const Scene& scene);

/// Several processes (mpirun) share assembled field solves and nothing else. Throws InputError if there are several and
/// `field` asks for another solver; null: no field is solved at all.
void check_processes(const FieldTable* field);

/// Electrostatics of conductors with given charges (D 5.3). Owns the field solver. A field solve costs more than all
/// mechanics of a step together, so forces are held: add_forces adds those of a HeldField, which others keep.
class FloatingConductors : public Effect {
 public:
  FloatingConductors(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver);  ///< of a plane scene
  FloatingConductors(const Scene& scene, laplace::SphereSolver solver);                    ///< of one in space

  const EffectKind& kind() const override { return FloatingConductorsOptions::kind(); }
  Needs needs() const override { return {.charges = true, .field = true}; }
  void add_forces(const State& state, std::span<double> force) const override;
  /// Held forces are linear in time: free flight has a closed form for them.
  void mark_pushed(const Bodies&, std::span<const double>, std::vector<bool>&) const override {}

  /// Solves the field. Throws what the solver throws, and Failure (InputError before the first solve) for a conductor
  /// outside the domain, or one that touches another potential in a scene without contact_discharge.
  Electrostatics solve(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);

  /// From now on predict() can be called: `predictor` solves the same problems, coarsely. Not in a scene with a
  /// circuit.
  void set_predictor(std::unique_ptr<laplace::LaplaceSolver> predictor) { predictor_ = std::move(predictor); }
  laplace::LaplaceSolver* predictor() { return predictor_.get(); }
  /// What solve() would find, for a fraction of its cost: the predictor's solution and what it was found to be wrong by
  /// at the last correct(). Throws what solve() throws.
  Electrostatics predict(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);
  /// Tells the predictor by what it was wrong: `solved` is what solve() found for the last prediction's problem.
  void correct(const Electrostatics& solved);
  /// The solvers' next solves depend on their problems alone.
  void forget();

  /// The last problem that was solved, if the scene asks for an accuracy: for checks of it.
  const std::optional<laplace::LaplaceProblem>& last_problem() const { return last_problem_; }
  /// From now on these forces act, as they are at any time. `held` must outlive this.
  void follow(const HeldField& held) { held_ = &held; }

  laplace::LaplaceSolver* solver() { return solver_.get(); }  ///< null in three dimensions
  std::int64_t solves() const { return solves_; }
  std::int64_t iterations() const { return iterations_; }  ///< of the linear solver, all solves together
  std::int64_t predictions() const { return predictions_; }
  void set_counters(std::int64_t solves, std::int64_t iterations, std::int64_t predictions) {
    solves_ = solves, iterations_ = iterations, predictions_ = predictions;
  }

 private:
  void check(const Bodies& bodies, const ElectricalGroups& groups) const;
  Electrostatics solve_in_space(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges);
  void ask(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges, AskedField& asked) const;
  Electrostatics in_si(const AskedField& asked, const laplace::LaplaceSolution& solution,
                       const ElectricalGroups& groups, const NodeCharges& charges) const;
  Electrostatics of_conductors(const AskedField& asked, const laplace::LaplaceSolution& solution) const;
  void check_contacts(const Bodies& bodies, const ElectricalGroups& groups) const;

  Scene scene_;
  std::unique_ptr<laplace::LaplaceSolver> solver_, predictor_;  ///< none: null
  std::optional<laplace::SphereSolver> spheres_;                ///< in place of solver_ in three dimensions
  std::vector<Terminal> terminals_;
  AskedField asked_, predicted_;        ///< of the last solve and prediction
  laplace::LaplaceSolution coarse_;     ///< the predictor's last solution
  Electrostatics correction_;           ///< what to add to it
  std::vector<double> corrected_norm_;  ///< N, of the predictor's forces when it was corrected last
  std::optional<laplace::LaplaceProblem> last_problem_;
  const HeldField* held_ = nullptr;  ///< null: no forces
  std::int64_t solves_ = 0, iterations_ = 0, predictions_ = 0;
};

/// With the solver that the scene asks for, at the tolerance of a moving scene, and a predictor if it has one.
std::unique_ptr<FloatingConductors> make_floating_conductors(const Scene& scene);

}  // namespace lichtenberg::effects
