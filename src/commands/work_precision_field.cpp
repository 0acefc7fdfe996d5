#include <fmt/format.h>
#include <petscksp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/field_problem.hpp"
#include "src/commands/work_precision.hpp"

namespace lichtenberg::work_precision {
namespace {

using laplace::CutCellOptions;
using laplace::LaplaceProblem;
using laplace::LaplaceSolution;
using laplace::LaplaceSolver;

enum FieldQuantity { potentials, charges, forces, quantities };

/// Largest deviation of each quantity.
using Magnitudes = std::array<double, quantities>;

struct Comparison {
  /// number of conductors, the first bodies of the problem; forces on electrodes are not compared
  std::size_t conductors = 0;

  Magnitudes difference(const LaplaceSolution& one, const LaplaceSolution& other) const {
    Magnitudes largest{};
    for (std::size_t g = 0; g < one.group_potential.size(); ++g)
      raise(largest[potentials], one.group_potential[g] - other.group_potential[g]);
    for (std::size_t b = 0; b < one.body_charge.size(); ++b)
      raise(largest[charges], one.body_charge[b] - other.body_charge[b]);
    for (std::size_t b = 0; b < conductors; ++b) raise(largest[forces], norm(one.body_force[b] - other.body_force[b]));
    return largest;
  }

  Magnitudes largest(const LaplaceSolution& solution) const {
    LaplaceSolution zero;
    zero.group_potential.resize(solution.group_potential.size());
    zero.body_charge.resize(solution.body_charge.size());
    zero.body_force.resize(solution.body_force.size());
    return difference(solution, zero);
  }

  std::vector<double> relative(const LaplaceSolution& solution, const LaplaceSolution& reference) const {
    const Magnitudes error = difference(solution, reference), scale = largest(reference);
    std::vector<double> result;
    for (int q = 0; q < quantities; ++q) result.push_back(scale[q] > 0 ? error[q] / scale[q] : error[q]);
    return result;
  }

 private:
  /// Raises `largest` to |value|; NaN is kept.
  static void raise(double& largest, double value) {
    if (!(std::abs(value) <= largest)) largest = std::abs(value);
  }
};

struct Reference {
  LaplaceSolution solution;
  std::string description;
  std::vector<double> errors;  ///< estimated, relative, by quantity
};

LaplaceSolution solve_on_grid(const LaplaceProblem& problem, int cells, double tolerance) {
  return laplace::CutCellSolver({.cells = cells, .tolerance = tolerance}).solve(problem);
}

/// Computes the reference by the multipole method if it can solve the problem. Otherwise uses the cut-cell method with
/// twice the finest size of the sweep. For a second-order method, the error is a third of the difference from half as
/// many cells.
Reference find_reference(const LaplaceProblem& problem, const Comparison& comparison, int finest) {
  constexpr double tolerance = 1e-12;
  try {
    Reference reference;
    reference.solution = laplace::MultipoleSolver({.tolerance = tolerance}).solve(problem);
    reference.errors.assign(quantities, reference.solution.residual);
    reference.description = fmt::format("the multipole method at tolerance {:g}", tolerance);
    return reference;
  } catch (const InputError& refusal) {
    constexpr double grid_tolerance = 1e-11;  // much smaller than the grid error
    Reference reference;
    reference.solution = solve_on_grid(problem, 2 * finest, grid_tolerance);
    reference.errors = comparison.relative(solve_on_grid(problem, finest, grid_tolerance), reference.solution);
    for (double& error : reference.errors) error /= 3;
    reference.description =
        fmt::format("the cut-cell method at S = {}, tolerance {:g} ({})", 2 * finest, grid_tolerance, refusal.what());
    return reference;
  }
}

/// PETSc options during the lifetime of this object, as on its command line.
class PetscSetting {
 public:
  using Options = std::vector<std::pair<const char*, const char*>>;
  explicit PetscSetting(Options options) : options_(std::move(options)) {
    if (!options_.empty()) parallel::start_petsc();
    for (const auto& [name, value] : options_) parallel::check_petsc(PetscOptionsSetValue(nullptr, name, value));
  }
  ~PetscSetting() {
    for (const auto& [name, value] : options_) PetscOptionsClearValue(nullptr, name);
  }
  PetscSetting(const PetscSetting&) = delete;

 private:
  Options options_;
};

struct FieldSubject {
  LaplaceProblem problem;
  Comparison comparison;
  Reference reference;
};

using MakeSolver = std::function<std::unique_ptr<LaplaceSolver>()>;

/// Trial: a field solve without an initial guess from earlier solves.
class FieldTrial : public Trial {
 public:
  FieldTrial(const FieldSubject& subject, const PetscSetting::Options& options, const MakeSolver& make)
      : subject_(subject), setting_(options), solver_(make()) {}

  void run() override {
    solver_->forget();
    solution_ = solver_->solve(subject_.problem);
  }
  std::vector<double> errors() const override {
    return subject_.comparison.relative(solution_, subject_.reference.solution);
  }
  std::int64_t work() const override { return solution_.iterations; }
  double evaluations() const override { return solution_.work; }

 private:
  const FieldSubject& subject_;
  PetscSetting setting_;
  std::unique_ptr<LaplaceSolver> solver_;
  LaplaceSolution solution_;
};

/// Returns candidates for all sizes and tolerances.
template <class Cost, class Make>
std::vector<Candidate> grid_candidates(const FieldSubject& subject, const std::vector<int>& sizes,
                                       const std::vector<double>& tolerances, const PetscSetting::Options& options,
                                       Cost cost, Make make) {
  std::vector<Candidate> candidates;
  for (const int cells : sizes)
    for (const double tolerance : tolerances)
      candidates.push_back({{{"S", cells}, {"tolerance", tolerance}},
                            cost(static_cast<double>(cells), tolerance),
                            [&subject, options, make, cells, tolerance] {
                              return std::make_unique<FieldTrial>(subject, options,
                                                                  [&] { return make(cells, tolerance); });
                            }});
  return candidates;
}

auto make_cut_cell(const CutCellOptions& options) {
  return [options](int cells, double tolerance) {
    CutCellOptions own = options;
    own.cells = cells;
    own.tolerance = tolerance;
    return std::make_unique<laplace::CutCellSolver>(own);
  };
}

Method cut_cell(const FieldSubject& subject, const std::vector<int>& sizes, const std::string& name,
                const std::string& description, const CutCellOptions& options) {
  const auto cost = [](double cells, double tolerance) { return cells * cells * (3 - std::log10(tolerance)); };
  return {name, description,
          grid_candidates(subject, sizes, {1e-2, 1e-3, 1e-4, 1e-6, 1e-8}, {}, cost, make_cut_cell(options))};
}

/// Returns the cut-cell method with an assembled matrix, for a PETSc preconditioner. Its setup dominates the time, so
/// two tolerances suffice.
Method assembled(const FieldSubject& subject, const std::vector<int>& sizes, const std::string& name,
                 const std::string& description, const PetscSetting::Options& petsc, CutCellOptions options = {}) {
  options.linear_solver = CutCellOptions::LinearSolver::assembled;
  const auto cost = [](double cells, double tolerance) { return cells * cells * (10 - std::log10(tolerance)); };
  return {name, description, grid_candidates(subject, sizes, {1e-3, 1e-6}, petsc, cost, make_cut_cell(options))};
}

/// Returns the method with a factorized matrix. One tolerance suffices; the fill grows faster than the unknowns.
Method factorized(const FieldSubject& subject, const std::vector<int>& sizes) {
  const auto cost = [](double cells, double) { return cells * cells * cells; };
  const PetscSetting::Options petsc{{"-field_pc_type", "cholesky"}, {"-field_pc_factor_mat_solver_type", "cholmod"}};
  return {"cut-cell-cholmod", "the same system as a matrix, factorized by CHOLMOD",
          grid_candidates(subject, sizes, {1e-8}, petsc, cost,
                          make_cut_cell({.linear_solver = CutCellOptions::LinearSolver::assembled}))};
}

/// Returns the relaxation method. Its error is of first order in the spacing, so tolerances below 1e-3 have no effect.
Method relaxation(const FieldSubject& subject, const std::vector<int>& sizes) {
  const auto cost = [](double cells, double tolerance) { return cells * cells * cells * -std::log10(tolerance); };
  const auto make = [](int cells, double tolerance) {
    return std::make_unique<laplace::RelaxationSolver>(
        laplace::RelaxationOptions{.sites = cells, .tolerance = tolerance});
  };
  return {"relaxation",
          "the dissertation's scheme: over-relaxed lattice, gradient descent on the potentials (D 6.3-6.5)",
          grid_candidates(subject, sizes, {1e-1, 1e-2, 1e-3}, {}, cost, make)};
}

Method multipole(const FieldSubject& subject) {
  Method method{"multipole", "spectral: a logarithm and Fourier multipoles a disk, walls as mirrors", {}};
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10}) {
    const auto make = [tolerance] {
      return std::make_unique<laplace::MultipoleSolver>(laplace::MultipoleOptions{.tolerance = tolerance});
    };
    method.candidates.push_back({{{"tolerance", tolerance}}, -std::log10(tolerance), [&subject, make] {
                                   return std::make_unique<FieldTrial>(subject, PetscSetting::Options{}, make);
                                 }});
  }
  return method;
}

std::vector<Method> all_methods(const FieldSubject& subject, const std::vector<int>& sizes) {
  const std::string matrix = "the same system as a matrix, conjugate gradients with ";
  const PetscSetting::Options gamg{{"-field_pc_type", "gamg"}};
  const auto cuda = CutCellOptions::Device::cuda;
  return {cut_cell(subject, sizes, "cut-cell", "finite volumes, log-fitted links, matrix-free multigrid", {}),
          cut_cell(subject, sizes, "cut-cell-plain", "the same with links 1 / cut length",
                   {.links = laplace::LinkFormula::plain}),
          assembled(subject, sizes, "cut-cell-gamg", matrix + "PETSc's GAMG", gamg),
#ifdef PETSC_HAVE_HYPRE
          assembled(subject, sizes, "cut-cell-boomeramg", matrix + "hypre's BoomerAMG",
                    {{"-field_pc_type", "hypre"},
                     {"-field_pc_hypre_boomeramg_coarsen_type", "HMIS"},
                     {"-field_pc_hypre_boomeramg_interp_type", "ext+i"},
                     {"-field_pc_hypre_boomeramg_agg_nl", "1"}}),
#endif
          assembled(subject, sizes, "cut-cell-aperture",
                    "cut-cell-gamg with fluxes surface / distance, the obvious cut cell", gamg,
                    {.links = laplace::LinkFormula::aperture}),
#ifdef PETSC_HAVE_SUITESPARSE
          factorized(subject, sizes),
#endif
          cut_cell(subject, sizes, "cut-cell-cuda", "cut-cell on a CUDA device", {.device = cuda}),
          assembled(subject, sizes, "cut-cell-gamg-cuda", "cut-cell-gamg on a CUDA device (aijcusparse)", gamg,
                    {.device = cuda}),
          relaxation(subject, sizes),
          multipole(subject)};
}

/// Converts an answer with values per conductor. Charges of electrodes are taken from the reference.
LaplaceSolution solution_of(const nlohmann::ordered_json& answer, const FieldSubject& subject, double depth) {
  LaplaceSolution solution = subject.reference.solution;
  for (std::size_t i = 0; i < subject.comparison.conductors; ++i) {
    solution.group_potential.at(subject.problem.bodies[i].group) = answer.at("potential").at(i);
    solution.body_charge.at(i) = answer.at("charge").at(i).get<double>() / depth;
    solution.body_force.at(i) = Vec2{answer.at("force").at(i).at(0), answer.at("force").at(i).at(1)} / depth;
  }
  return solution;
}

void check_sizes(const Scene& scene, const std::vector<int>& sizes) {
  constexpr int smallest = 8;
  const double longer = std::max(scene.domain.size.x, scene.domain.size.y),
               shorter = std::min(scene.domain.size.x, scene.domain.size.y);
  for (const int cells : sizes) {
    if (cells < smallest || cells > most_cells)
      throw InputError(
          fmt::format("--sizes {} is not allowed: {} to {} cells along the longer side of the domain are allowed",
                      cells, smallest, most_cells));
    const double across = shorter / longer * cells, whole = std::max(1.0, std::round(across));
    constexpr double rounding = 1e-9;  // of sides given as decimal numbers
    if (std::abs(across - whole) > rounding * whole)
      throw InputError(
          fmt::format("--sizes {} is not allowed: the domain's shorter side would have {:g} cells, and only a whole "
                      "number is allowed",
                      cells, across));
  }
}

}  // namespace

void sweep_field(const Scene& scene, const Request& request) {
  std::vector<int> sizes = request.sizes;
  if (sizes.empty()) sizes = {128, 256, 512, 1024, 2048};
  std::ranges::sort(sizes);
  check_sizes(scene, sizes);
  check_side_potentials(scene);
  FieldSubject subject{
      .problem = make_field_problem(scene).problem, .comparison = {scene.conductors.size()}, .reference = {}};
  subject.problem.check();
  const std::vector<Method> methods = choose(all_methods(subject, sizes), request);
  request.begin();
  subject.reference = find_reference(subject.problem, subject.comparison, sizes.back());
  Diagram diagram{.title = fmt::format("field of {} conductors in {} groups", scene.conductors.size(),
                                       subject.problem.groups.size()),
                  .quantities = {"potentials", "charges", "forces"},
                  .measure = "the largest of all conductors, relative to the largest potential, charge or force",
                  .work = "iterations",
                  .reference = subject.reference.description,
                  .reference_errors = subject.reference.errors};
  diagram.errors = [&](const nlohmann::ordered_json& answer) {
    return subject.comparison.relative(solution_of(answer, subject, scene.medium.depth), subject.reference.solution);
  };
  request.serve(diagram, methods);
}

}  // namespace lichtenberg::work_precision
