// Compares with the reference solutions in data/reference-disks (12-13 digits, an independent method; see their README)
// at S = 512: potentials, forces, charges, capacitances, energy and the field at probes.
//
//   reference_disks         cut-cell at S = 512; seconds
//   reference_disks long    also orders of convergence from S = 128 to 1024, and the relaxation at S = 512

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/relaxation/solver.hpp"
#include "validation/program.hpp"
#include "validation/reference_cases.hpp"

namespace reference_disks_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;
using nlohmann::json;

namespace {

/// Returns the error of each disk, in percent of the largest value of all disks.
Spread potential_error(const validation::Reference& reference, const LaplaceSolution& solution) {
  const json& exact = reference.data["reference"]["phi_disk"];
  double largest = 0;
  for (const double phi : exact) largest = std::max(largest, std::abs(phi));
  std::vector<double> error;
  for (std::size_t b = 0; b < exact.size(); ++b)
    error.push_back(100 * (solution.group_potential[reference.problem.bodies[b].group] - exact[b].get<double>()) /
                    largest);
  return spread(error);
}

Spread force_error(const validation::Reference& reference, const LaplaceSolution& solution) {
  std::vector<Vec2> exact;
  double largest = 0;
  for (const json& force : reference.data["reference"]["force"]) {
    exact.push_back({force[0], force[1]});
    largest = std::max(largest, norm(exact.back()));
  }
  std::vector<double> error;
  for (std::size_t b = 0; b < exact.size(); ++b)
    error.push_back(100 * norm(solution.body_force[b] - exact[b]) / largest);
  return spread(error);
}

/// Returns the errors of given charges, due to the rounding of a sum over some hundred links. Members' charges count
/// only if they are alone in their group.
Spread charge_error(const validation::Reference& reference, const LaplaceSolution& solution) {
  std::vector<double> error;
  for (std::size_t b = 0; b < reference.problem.bodies.size(); ++b)
    if (reference.problem.groups[reference.problem.bodies[b].group].floating)
      error.push_back(solution.body_charge[b] - reference.data["reference"]["Q_disk"][b].get<double>());
  return spread(error);
}

double capacitance_error(const validation::Reference& reference, LaplaceSolver& solver) {
  const json& exact = reference.data["reference"]["capacitance_conductor"];
  const std::vector<double> computed = capacitance_matrix(solver, reference.problem);
  double largest = 0, worst = 0;
  for (std::size_t i = 0; i < exact.size(); ++i)
    for (std::size_t j = 0; j < exact.size(); ++j) {
      largest = std::max(largest, std::abs(exact[i][j].get<double>()));
      worst = std::max(worst, std::abs(computed[i * exact.size() + j] - exact[i][j].get<double>()));
    }
  return 100 * worst / largest;
}

/// Returns the bilinear interpolation between cell centres. The probes are in the fluid, some closer than a cell to a
/// surface.
double at(const Field& field, Vec2 p) {
  const double x = p.x / field.h - 0.5, y = p.y / field.h - 0.5;
  const int i = std::clamp(static_cast<int>(std::floor(x)), 0, field.nx - 2);
  const int j = std::clamp(static_cast<int>(std::floor(y)), 0, field.ny - 2);
  const double fx = x - i, fy = y - j;
  const double* v = field.value.data() + j * field.nx + i;
  return (1 - fy) * ((1 - fx) * v[0] + fx * v[1]) + fy * ((1 - fx) * v[field.nx] + fx * v[field.nx + 1]);
}

Spread probe_error(const validation::Reference& reference, const Field& field) {
  double largest = 0;
  for (const double phi : reference.data["reference"]["phi_disk"]) largest = std::max(largest, std::abs(phi));
  std::vector<double> error;
  for (const json& probe : reference.data["reference"]["probes"]) {
    const Vec2 p = Vec2{probe["x"], probe["y"]} + reference.shift;
    const bool inside = p.x > 0 && p.y > 0 && p.x < reference.problem.size.x && p.y < reference.problem.size.y;
    if (inside) error.push_back(100 * (at(field, p) - probe["V"].get<double>()) / largest);
  }
  return spread(error);
}

/// Bounds: potentials 0.05 % of the largest, forces 0.5 %. Capacitances and the energy, 1/2 sum Q phi, have the
/// potentials' bound.
void compare(Report& report, const validation::Reference& reference) {
  constexpr double potential_bound = 0.05, force_bound = 0.5;
  CutCellSolver solver({.cells = 512});
  const LaplaceSolution solution = solver.solve(reference.problem);
  const std::string& name = reference.name;
  report.at_most(name + ": potentials, % of the largest", potential_error(reference, solution), potential_bound);
  report.at_most(name + ": forces, % of the largest", force_error(reference, solution), force_bound);
  report.at_most(name + ": potential at probes, %", probe_error(reference, solver.field()), potential_bound);
  report.at_most(name + ": given charges", charge_error(reference, solution), 1e-10);
  if (reference.plane) return;  // the box's capacitance and energy differ from the plane's
  const double energy = reference.data["reference"]["energy"];
  report.at_most(name + ": energy, %", 100 * std::abs(solution.energy / energy - 1), potential_bound);
  report.at_most(name + ": capacitance matrix, % of its largest", capacitance_error(reference, solver),
                 potential_bound);
  if (const auto& data = reference.data["reference"]; data.contains("Q_electrode")) {
    double total = 0;
    for (const double q : solution.side_charge) total += q;
    report.at_most(name + ": charge of the electrode, %", 100 * std::abs(total / data["Q_electrode"].get<double>() - 1),
                   1e-6);
  }
}

void convergence(Report& report, const validation::Reference& reference) {
  const std::vector<double> cells = {128, 256, 512, 1024};
  std::vector<double> potential, force;
  for (const double s : cells) {
    const LaplaceSolution solution = CutCellSolver({.cells = static_cast<int>(s)}).solve(reference.problem);
    potential.push_back(potential_error(reference, solution).worst);
    force.push_back(force_error(reference, solution).worst);
  }
  report.at_least(reference.name + ": order of the potentials", order(cells, potential), 1.7);
  report.at_least(reference.name + ": order of the forces", order(cells, force), 1.7);
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Reference solutions of circular conductors, S = 512");
  const std::vector<validation::Reference> cases = read_all();
  report.section(fmt::format("cut-cell, {} cases", cases.size()));
  for (const validation::Reference& reference : cases) compare(report, reference);
  if (long_run_requested(argc, argv)) {
    report.section("cut-cell, S = 128 ... 1024");  // two_disks covers the pairs in the plane
    for (const validation::Reference& reference : cases)
      if (!reference.plane) convergence(report, reference);
    report.section("relaxation, S = 512");
    for (const validation::Reference& reference : cases) {
      const LaplaceSolution solution = RelaxationSolver().solve(reference.problem);
      report.at_most(reference.name + ": potentials, % of the largest", potential_error(reference, solution), {});
      report.at_most(reference.name + ": forces, % of the largest", force_error(reference, solution), {});
    }
  }
  return report.exit_status();
}

const lichtenberg::validation::Program program("reference_disks", validate);

}  // namespace reference_disks_validation
