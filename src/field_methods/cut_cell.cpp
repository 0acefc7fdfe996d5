#include "src/field_methods/cut_cell.hpp"

#include <fmt/format.h>

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/field_methods/field_method.hpp"

namespace lichtenberg {
namespace {

laplace::LinkFormula link_formula(FieldLinks links) {
  if (links == FieldLinks::plain) return laplace::LinkFormula::plain;
  return links == FieldLinks::aperture ? laplace::LinkFormula::aperture : laplace::LinkFormula::log_fitted;
}

std::string on_devices(const std::vector<int>& numbers) {
  if (numbers.empty()) return ", on a CUDA device";
  return fmt::format(", rows divided among {} CUDA devices",
                     numbers.front() < 0 ? "all" : std::to_string(numbers.size()));
}

std::string describe(const FieldOptions& options) {
  const int processes = parallel::process_count();
  return fmt::format("cut-cell finite volumes, {} links; conjugate gradients, {}{}{}", name_of(options.links),
                     options.linear_solver == FieldLinearSolver::assembled
                         ? "assembled matrix with a preconditioner of PETSc's"
                         : "matrix-free with geometric multigrid",
                     options.device == FieldDevice::cuda ? on_devices(options.cuda_devices) : "",
                     processes > 1 ? fmt::format(", rows divided among {} processes", processes) : "");
}

FieldMethodCost cost(const FieldOptions& options) {
  if (runs_on_device(options)) return {laplace::cut_cell_cost_on_device};
  // On a processor, the cost includes cell owners and links on all grids.
  constexpr double seconds_a_conductor = 5e-6;
  const bool assembled = options.linear_solver == FieldLinearSolver::assembled;
  return {assembled ? laplace::assembled_cost : laplace::cut_cell_cost, seconds_a_conductor};
}

void follow(laplace::LaplaceSolver& fine, laplace::LaplaceSolver& coarse) {
  dynamic_cast<laplace::CutCellSolver&>(fine).follow(dynamic_cast<laplace::CutCellSolver&>(coarse));
}

}  // namespace

laplace::CutCellOptions cut_cell_options(const FieldOptions& options) {
  using CutCell = laplace::CutCellOptions;
  const bool assembled = options.linear_solver == FieldLinearSolver::assembled;
  std::uint64_t devices = 0;
  for (const int number : options.cuda_devices)
    devices |= number < 0 ? CutCell::all_cuda_devices : std::uint64_t{1} << number;
  return {.cells = options.cells,
          .tolerance = options.tolerance,
          .links = link_formula(options.links),
          .threads = options.threads,
          .linear_solver = assembled ? CutCell::LinearSolver::assembled : CutCell::LinearSolver::multigrid,
          .device = options.device == FieldDevice::cuda ? CutCell::Device::cuda : CutCell::Device::cpu,
          .cuda_devices = devices};
}

const FieldMethodKind& cut_cell_method() {
  static const FieldMethodKind kind = {
      .name = "cut-cell",
      .help = "finite volumes on a Cartesian grid with cut cells, one linear system for potentials and charges",
      .describe = describe,
      .make = [](const FieldOptions& options) -> std::unique_ptr<laplace::LaplaceSolver> {
        return std::make_unique<laplace::CutCellSolver>(cut_cell_options(options));
      },
      .follow = follow,
      .cost = cost,
      .accuracy = laplace::Method::cut_cell,
      .on_device = true,
      .couplings = true,
      .on_grid = true,
      .curves = true,
      .moving_by_positions = true,
      .on_processes = true,
      .energy_noise = 30};  // above the values in docs/measurements/mechanics.json
  return kind;
}

}  // namespace lichtenberg
