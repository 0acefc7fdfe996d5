#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/laplace/accuracy/cost_model.hpp"
#include "src/field_methods/field_options.hpp"

namespace lichtenberg {

namespace laplace {
enum class Method;
class LaplaceSolver;
class SphereSolver;
struct LaplaceProblem;
}  // namespace laplace

/// Relative tolerances of a field method: defaults for a single solve and for moving scenes, and the limit of rounding.
struct FieldTolerances {
  double single = 1e-8;  ///< tolerance of a single solve
  double moving = 1e-5;  ///< tolerance of a solve in a moving scene
  double least = 1e-14;  ///< limit below which rounding ends the iteration
};

/// Cost of a field method, for estimates of the time of a solve.
struct FieldMethodCost {
  laplace::CostModel solve;
  double seconds_a_conductor = 3e-7;  ///< s, in each solve of a run, for groups, charges and motion
  /// Fraction of the iterations that remains where earlier solutions give the initial guess
  double share_in_motion = 0.8;
};

/// Declaration of a method that solves Laplace's equation for scenes: its properties, and a maker of its solver. Code
/// uses these properties, never the name. A null function or a flag that is false means that the method lacks the
/// ability, unless the member's comment says otherwise.
struct FieldMethodKind {
  std::string name;  ///< value of field.method
  std::string help;  ///< text after the name in `help scene`
  /// Describes the method with these options for `explain`. Null: `help`.
  std::string (*describe)(const FieldOptions&) = nullptr;

  /// Makes a two-dimensional solver, at the tolerance of a single solve. Null: the method is not two-dimensional.
  std::unique_ptr<laplace::LaplaceSolver> (*make)(const FieldOptions&) = nullptr;
  /// Makes a three-dimensional solver for a scene of n conductors. Null: the method is not three-dimensional.
  laplace::SphereSolver (*make_in_space)(const FieldOptions&, std::size_t n) = nullptr;
  /// Couples two solvers of the method: the initial guess of `fine` then includes the changes that `coarse`, a solver
  /// with fewer cells, has computed. Null: the method does not predict forces on a coarser grid.
  void (*follow)(laplace::LaplaceSolver& fine, laplace::LaplaceSolver& coarse) = nullptr;
  /// Returns the number of unknowns of a problem, for estimates. Null: the number of cells if `on_grid`, else the
  /// number of bodies.
  long (*unknowns)(const laplace::LaplaceProblem&, const FieldOptions&) = nullptr;
  /// Returns the cost model of the method. Null: the default.
  FieldMethodCost (*cost)(const FieldOptions&) = nullptr;

  /// Keys of [field] that a scene may give in addition to method, tolerance, moving_tolerance and device. The default
  /// has the keys of the built-in methods, so that --set field.method compares methods on one scene. Other keys are
  /// refused.
  std::vector<std::string> keys = {"cells", "threads", "boundary_stencil", "linear_solver", "relaxation_eta"};
  FieldTolerances tolerance{};
  /// Error estimator for field.accuracy. Empty: none, and field.accuracy is refused in two dimensions.
  std::optional<laplace::Method> accuracy{};

  bool on_device = false;            ///< true: also runs on a CUDA device
  bool couplings = false;            ///< true: supports resistors between groups of conductors
  bool on_grid = false;              ///< true: field.cells sets its resolution
  bool only_disks = false;           ///< true: supports no electrodes of other shapes
  bool curves = false;               ///< true: supports electrodes of shape polygon, ellipse and curve
  bool only_separate = false;        ///< true: supports no overlaps, so a run needs contact forces
  bool moving_by_positions = false;  ///< true: the default of moving_tolerance depends on mechanics.position_tolerance
  bool on_processes = false;         ///< true: several processes (mpirun) share a solve
  double least_radius = 0;           ///< smallest radius of a conductor, in cells; 0: no limit
  /// Noise of the field energy: relative difference between two solves of one state, in units of moving_tolerance.
  double energy_noise = 8;

  /// Returns true if the method solves problems of this dimension (2 or 3).
  bool solves(int dimension) const { return dimension == 3 ? make_in_space != nullptr : make != nullptr; }
  /// Returns true if a scene may give this key of [field] with the method.
  bool takes(std::string_view key) const;
};

using FieldMethodKinds = std::vector<const FieldMethodKind*>;

/// Returns the field methods that scenes may name: the built-in methods first, then those of add_field_method().
const FieldMethodKinds& field_methods();

/// Registers a field method, which must outlive all scenes. Call it before any scene is read. Throws InputError if its
/// name is taken or if it makes no solver.
void add_field_method(const FieldMethodKind& method);

/// Returns the field method with this name; null if there is none.
const FieldMethodKind* find_field_method(std::string_view name);

/// Returns the default field method of this dimension (2 or 3): the first one of field_methods() that solves it.
const FieldMethodKind& usual_field_method(int dimension);

/// Returns the names of the field methods of a dimension (2 or 3) for which `have` is true, for messages: `"a", "b" and
/// "c"`.
std::string field_methods_that(int dimension, const std::function<bool(const FieldMethodKind&)>& have);

/// Returns the cost of a field solve with these options.
FieldMethodCost field_method_cost(const FieldOptions& options);

/// Returns true if field solves with these options run on a CUDA device.
bool runs_on_device(const FieldOptions& options);

}  // namespace lichtenberg
