#pragma once

#include <optional>

#include "src/scene/choice.hpp"

namespace lichtenberg {

struct FieldMethodKind;

/// Methods of the plane.
const FieldMethodKind& cut_cell_method();
const FieldMethodKind& multipole_method();
const FieldMethodKind& relaxation_method();
/// The method of space.
const FieldMethodKind& spheres_method();

/// Largest number of cells along the domain's longer side.
constexpr int most_cells = 32768;

enum class FieldDevice { cpu, cuda };
template <>
inline constexpr Named<FieldDevice> values_named<FieldDevice>[] = {{FieldDevice::cpu, "cpu"},
                                                                   {FieldDevice::cuda, "cuda"}};

/// Formulas for the conductance from a cell to a disk.
enum class FieldLinks { log_fitted, plain, aperture };
template <>
inline constexpr Named<FieldLinks> values_named<FieldLinks>[] = {
    {FieldLinks::log_fitted, "log-fitted"}, {FieldLinks::plain, "plain"}, {FieldLinks::aperture, "aperture"}};

/// Matrix-free, or with any preconditioner of PETSc.
enum class FieldLinearSolver { multigrid, assembled };
template <>
inline constexpr Named<FieldLinearSolver> values_named<FieldLinearSolver>[] = {
    {FieldLinearSolver::multigrid, "multigrid"}, {FieldLinearSolver::assembled, "assembled"}};

/// An accuracy that a field was chosen for: largest error of potentials, charges and forces, relative
/// (solvers/laplace/measure.hpp).
struct FieldAccuracy {
  double asked = 0;
  double estimate = 0;  ///< of the error
};

/// Options of a field method.
struct FieldOptions {
  const FieldMethodKind* method = &cut_cell_method();
  int cells = 512;                 ///< S: cells along the domain's longer side; multipole: of the output
  double tolerance = 1e-8;         ///< error of a single solve, relative; default by method
  double moving_tolerance = 1e-5;  ///< error of a solve of a moving scene, relative
  FieldDevice device = FieldDevice::cpu;
  int threads = 0;  ///< of the cut-cell method; 0: all cores, fewer on small grids
  FieldLinks links = FieldLinks::log_fitted;
  FieldLinearSolver linear_solver = FieldLinearSolver::multigrid;
  double relaxation_eta = 0;                  ///< step of the gradient descent (D 6.30), V m/C; 0: chosen by the solver
  std::optional<FieldAccuracy> chosen_for{};  ///< empty: the scene says all of the above
};

/// A requested accuracy in place of cells and tolerances: effects::with_field_chosen makes FieldOptions of it.
struct FieldRequest {
  double accuracy = 0;                      ///< as in FieldAccuracy
  const FieldMethodKind* method = nullptr;  ///< null: to be chosen
  FieldDevice device = FieldDevice::cpu;
  int threads = 0;
  FieldLinearSolver linear_solver = FieldLinearSolver::multigrid;
};

}  // namespace lichtenberg
