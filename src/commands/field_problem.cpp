#include "src/commands/field_problem.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/error.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_conductors.hpp"

namespace lichtenberg {
namespace {

std::string name_of_group(const Scene& scene, const std::vector<int>& members) {
  for (const int i : members)
    if (const int wire = scene.conductors[i].group; wire >= 0) return scene.groups[wire].name;
  return fmt::format("conductor{} {}", members.size() > 1 ? "s" : "", fmt::join(members, ", "));
}

std::vector<std::string> name_groups(const Scene& scene, const laplace::LaplaceProblem& problem) {
  std::vector<std::vector<int>> members(problem.groups.size());
  for (std::size_t i = 0; i < scene.conductors.size(); ++i)
    members[problem.bodies[i].group].push_back(static_cast<int>(i));
  std::vector<std::string> names(problem.groups.size());
  for (std::size_t e = 0; e < scene.electrodes.size(); ++e)
    names[problem.bodies[scene.conductors.size() + e].group] = scene.electrodes[e].name;
  for (std::size_t g = 0; g < names.size(); ++g)
    if (!members[g].empty()) names[g] = name_of_group(scene, members[g]);
  return names;
}

std::string linear_solver_in_words(const FieldOptions& field) {
  if (field.linear_solver == FieldLinearSolver::assembled) return "assembled matrix with a preconditioner of PETSc's";
  return "matrix-free with geometric multigrid";
}

}  // namespace

std::string method_in_words(const FieldOptions& field) {
  if (field.method == FieldMethod::relaxation)
    return "relaxation (D 6.3-6.5): over-relaxed lattice, gradient descent on the floating potentials";
  if (field.method == FieldMethod::multipole)
    return "multipole: spectral, a Fourier series a disk and walls as mirrors; GMRES with FFT";
  return fmt::format("cut-cell finite volumes, {} links; conjugate gradients, {}{}", name_of(field.links),
                     linear_solver_in_words(field), field.device == FieldDevice::cuda ? ", on a CUDA device" : "");
}

std::string choice_in_words(const FieldOptions& field) {
  const std::string grid = field.method == FieldMethod::multipole ? "" : fmt::format("{} cells, ", field.cells);
  return fmt::format("{}, {}tolerance {:.2g}: an estimated error of {:.1e}, where {:g} is allowed",
                     name_of(field.method), grid, field.tolerance, field.chosen_for->estimate, field.chosen_for->asked);
}

FieldProblem make_field_problem(const Scene& scene) {
  if (!scene.effects.has(&EffectKind::field))
    throw InputError(
        fmt::format("{} has no table [effects.floating_conductors], so there is no field to solve", scene.path));
  const Bodies bodies = make_bodies(scene);
  FieldProblem field;
  field.groups = effects::groups_at_start(scene, bodies);
  field.problem = effects::make_laplace_problem(scene, bodies, field.groups, {.charge = initial_charges(scene)});
  field.group_names = name_groups(scene, field.problem);
  return field;
}

}  // namespace lichtenberg
