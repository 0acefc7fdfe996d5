#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/laplace/accuracy/price.hpp"
#include "src/field_methods/field_options.hpp"

namespace lichtenberg {

namespace laplace {
enum class Method;
class LaplaceSolver;
class SphereSolver;
struct LaplaceProblem;
}  // namespace laplace

/// Tolerances of a method: defaults, and the limit of rounding.
struct FieldTolerances {
  double single = 1e-8;  ///< of a single solve
  double moving = 1e-5;  ///< of a solve of a moving scene
  double least = 1e-14;  ///< below it rounding ends the iteration
};

/// Cost of a method, for estimates.
struct FieldMethodPrice {
  laplace::Price of_a_solve;
  double seconds_a_conductor = 3e-7;  ///< of a solve in a run, for groups, charges and motion
  double share_in_motion = 0.8;       ///< of the iterations, where earlier solutions give the initial guess
};

/// A method that solves Laplace's equation for scenes: its properties, and how its solver is made. Code uses these
/// properties, never the name. Defaults are those of a method without the ability.
struct FieldMethodKind {
  std::string name;  ///< value of field.method
  std::string help;  ///< text after the name in `help scene`
  /// Describes the method with these options for `explain`. Null: `help`.
  std::string (*describe)(const FieldOptions&) = nullptr;

  /// Makes a solver of the plane, at the tolerance of a single solve. Null: not a method of the plane.
  std::unique_ptr<laplace::LaplaceSolver> (*make)(const FieldOptions&) = nullptr;
  /// Makes a solver of space for a scene of n conductors. Null: not a method of space.
  laplace::SphereSolver (*make_in_space)(const FieldOptions&, std::size_t n) = nullptr;
  /// Lets the solver `fine` begin with the changes that `coarse`, of the same method on fewer cells, has found. Null:
  /// the method does not predict forces on a coarser grid.
  void (*follow)(laplace::LaplaceSolver& fine, laplace::LaplaceSolver& coarse) = nullptr;
  /// Unknowns of a problem, for estimates. Null: as many as cells if `on_grid`, else as many as bodies.
  long (*unknowns)(const laplace::LaplaceProblem&, const FieldOptions&) = nullptr;
  FieldMethodPrice (*price)(const FieldOptions&) = nullptr;  ///< Null: the default.

  /// Keys of [field] that a scene may give in addition to method, tolerance, moving_tolerance and device. The default
  /// takes those of the program's methods, so that --set field.method compares methods on one scene. Others are
  /// refused.
  std::vector<std::string> keys = {"cells", "threads", "links", "linear_solver", "relaxation_eta"};
  FieldTolerances tolerance{};
  /// Error estimator for field.accuracy. Empty: none, and field.accuracy is refused in the plane.
  std::optional<laplace::Method> accuracy{};

  bool on_device = false;            ///< runs on a CUDA device as well
  bool couplings = false;            ///< solves with resistors between groups of conductors
  bool on_grid = false;              ///< field.cells sets its resolution
  bool only_disks = false;           ///< no electrodes of other shapes
  bool only_separate = false;        ///< no overlaps: a run needs contact forces
  bool moving_by_positions = false;  ///< the default of moving_tolerance follows mechanics.position_tolerance
  /// Solves with this `linear_solver` share the work of several processes. Empty: none do.
  std::optional<FieldLinearSolver> on_processes{};
  double least_radius = 0;  ///< of a conductor, in cells; 0: any
  double energy_noise = 8;  ///< change of the energy between solves of one state, in moving_tolerances of the energy

  /// Whether it is a method of a space of two or three dimensions.
  bool solves(int dimension) const { return dimension == 3 ? make_in_space != nullptr : make != nullptr; }
  bool takes(std::string_view key) const;
};

using FieldMethodKinds = std::vector<const FieldMethodKind*>;

/// The methods that scenes may name: those of the program, then those that were added.
const FieldMethodKinds& field_methods();

/// Adds a method, which must outlive all scenes, before any scene is read. Throws InputError if its name is taken, or
/// if it makes no solver.
void add_field_method(const FieldMethodKind& method);

/// Null if there is none of that name.
const FieldMethodKind* find_field_method(std::string_view name);

/// The first method of that dimension.
const FieldMethodKind& usual_field_method(int dimension);

/// Names of the methods of a dimension that have a property, for error messages: `"a", "b" and "c"`.
std::string field_methods_that(int dimension, const std::function<bool(const FieldMethodKind&)>& have);

/// Cost of a solve with these options.
FieldMethodPrice price_of(const FieldOptions& options);

/// Whether solves with these options run on a CUDA device.
bool runs_on_device(const FieldOptions& options);

}  // namespace lichtenberg
