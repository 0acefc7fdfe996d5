#pragma once

#include <optional>
#include <vector>

#include "src/scene/choice.hpp"

namespace lichtenberg {

struct FieldMethodKind;

/// Returns the two-dimensional cut-cell method: finite volumes on a grid.
const FieldMethodKind& cut_cell_method();
/// Returns the two-dimensional multipole method: a Fourier series for each disk, and image charges for walls.
const FieldMethodKind& multipole_method();
/// Returns the two-dimensional relaxation method: over-relaxation on a lattice (D 6.3-6.5).
const FieldMethodKind& relaxation_method();
/// Returns the three-dimensional method: solid harmonics on each sphere, and image charges for walls.
const FieldMethodKind& spheres_method();

/// Largest number of cells along the domain's longer side.
constexpr int most_cells = 32768;

/// Device that solves the field.
enum class FieldDevice { cpu, cuda };
template <>
inline constexpr Named<FieldDevice> values_named<FieldDevice>[] = {{FieldDevice::cpu, "cpu"},
                                                                   {FieldDevice::cuda, "cuda"}};

/// Formulas of the cut-cell method for the conductance from a grid cell to the surface of a disk.
enum class FieldLinks { log_fitted, plain, aperture };
template <>
inline constexpr Named<FieldLinks> values_named<FieldLinks>[] = {
    {FieldLinks::log_fitted, "log-fitted"}, {FieldLinks::plain, "plain"}, {FieldLinks::aperture, "aperture"}};

/// Linear solvers of the cut-cell method: matrix-free multigrid, or an assembled matrix with any preconditioner of
/// PETSc.
enum class FieldLinearSolver { multigrid, assembled };
template <>
inline constexpr Named<FieldLinearSolver> values_named<FieldLinearSolver>[] = {
    {FieldLinearSolver::multigrid, "multigrid"}, {FieldLinearSolver::assembled, "assembled"}};

/// Accuracy for which field options were chosen: largest relative error of potentials, charges and forces
/// (solvers/laplace/measure.hpp).
struct FieldAccuracy {
  double requested = 0;
  double estimate = 0;  ///< estimated error
};

/// Options of the field solver, [field]: method, resolution, tolerances and device.
struct FieldOptions {
  const FieldMethodKind* method = &cut_cell_method();
  /// Number of grid cells along the domain's longer side; for multipole, cells of the output
  int cells = 512;
  double tolerance = 1e-8;         ///< relative error of a single solve; default by method
  double moving_tolerance = 1e-5;  ///< relative error of a solve in a moving scene
  FieldDevice device = FieldDevice::cpu;
  /// Numbers of the CUDA devices among which `multigrid` divides a field, up to 63; -1: all; none: the first
  std::vector<int> cuda_devices{};
  /// Threads of the methods cut-cell and spheres; 0: all cores, fewer on small grids or with few spheres
  int threads = 0;
  FieldLinks links = FieldLinks::log_fitted;
  FieldLinearSolver linear_solver = FieldLinearSolver::multigrid;
  double relaxation_eta = 0;                  ///< step of the gradient descent (D 6.30), V m/C; 0: chosen by the solver
  std::optional<FieldAccuracy> chosen_for{};  ///< empty: the scene specifies all of the above
};

/// A requested accuracy of the field instead of cells and tolerances. effects::with_field_chosen converts it to
/// FieldOptions.
struct FieldRequest {
  double accuracy = 0;                      ///< as in FieldAccuracy
  const FieldMethodKind* method = nullptr;  ///< null: still to be chosen
  FieldDevice device = FieldDevice::cpu;
  std::vector<int> cuda_devices{};  ///< as in FieldOptions
  int threads = 0;
  FieldLinearSolver linear_solver = FieldLinearSolver::multigrid;
};

}  // namespace lichtenberg
