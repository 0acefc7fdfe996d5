// Accuracy contract of the field of conductors in the plane: random disks, and bars and rings, with a requested
// accuracy (field.accuracy) or tolerance. Gaps are at least 0.01 radii.
//
//   contract_plane              a few cases: seconds
//   contract_plane long         500 cases of each guarantee
//   contract_plane FROM TO      the cases of these seeds

#include "solvers/error.hpp"
#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "validation/contract_scenes.hpp"
#include "validation/program.hpp"

namespace contract_plane_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

LaplaceProblem random_plane(CaseRandom& random) {
  const int count = static_cast<int>(random.pick({1, 2, 3, 10, 30}));
  const auto kind = static_cast<GroupKind>(random.whole(0, 2));
  const Packing packing = random_packing(random, 2, count, random.logarithmic(0.01, 1));
  LaplaceProblem problem{.size = {packing.size[0], packing.size[1]}, .permittivity = permittivity_of_oil};
  const double potential = random.logarithmic(5, 2000), held = random.pick({0, 0.3, 1});
  for (int side = 0; side < 4; ++side)
    if (side < 2 || random.chance(held))
      problem.sides[side] = {Side::Kind::electrode, random.pick({0, potential, -potential}), {}};
  if (kind == GroupKind::charged && random.chance(0.3)) problem.sides = {};
  if (kind == GroupKind::neutral) problem.sides[left].potential = potential + problem.sides[right].potential;
  add_bodies(problem, packing, random, kind, permittivity_of_oil * random.logarithmic(10, 1000),
             [&](std::size_t i, int group) {
               const auto& centre = packing.centres[i];
               problem.bodies.push_back({Disk{{centre[0], centre[1]}, packing.radii[i]}, group});
             });
  problem.movable = free_first(problem.bodies, problem.groups);
  return problem;
}

/// Returns a bar between two of three disks, in a ring, or in a ring that the box's sides cut.
LaplaceProblem random_shapes(CaseRandom& random) {
  LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  const auto near = [&](double x) { return x + random.uniform(-0.02, 0.02); };
  problem.bodies = {{Disk{{near(0.3), near(0.55)}, near(0.05)}, 0},
                    {Disk{{near(0.62), near(0.7)}, near(0.06)}, 1},
                    {Disk{{near(0.7), near(0.4)}, near(0.05)}, 2}};
  problem.groups = {{true, random.uniform(-1, 1), 0}, {true, random.uniform(-1, 1), 0}, {true, 0.3, 0}, {false, 0, 0}};
  const int kind = random.whole(0, 2);
  if (kind != 1) problem.bodies.push_back({Bar{{near(0.45), near(0.2)}, {near(0.5), near(0.6)}, 0.04}, 3});
  if (kind != 0) problem.bodies.push_back({Ring{{0.5, 0.5}, 0.5}, 3});
  return problem;
}

/// Returns true if electrodes of different potential meet at a corner, where the field's energy is infinite.
bool infinite_energy(const LaplaceProblem& problem) {
  for (const SideIndex across : {left, right})
    for (const SideIndex along : {bottom, top}) {
      const Side &a = problem.sides[across], &b = problem.sides[along];
      if (a.kind == Side::Kind::electrode && b.kind == Side::Kind::electrode && a.potential != b.potential) return true;
    }
  return false;
}

FieldErrors errors_of(const LaplaceProblem& problem, const LaplaceSolution& found, const LaplaceSolution& exact) {
  const Scales scales = scales_of(problem, exact);
  FieldErrors errors;
  for (std::size_t g = 0; g < exact.group_potential.size(); ++g)
    errors.potential =
        larger(errors.potential, std::abs(found.group_potential[g] - exact.group_potential[g]) / scales.potential);
  for (std::size_t b = 0; b < exact.body_charge.size(); ++b) {
    errors.charge =
        larger(errors.charge, scales.error_of_charge(std::abs(found.body_charge[b] - exact.body_charge[b])));
    if (has_force(problem, b))
      errors.force = larger(errors.force, scales.error_of_force(norm(found.body_force[b] - exact.body_force[b])));
  }
  errors.energy = infinite_energy(problem) ? INFINITY : std::abs(found.energy / exact.energy - 1);
  return errors;
}

constexpr std::size_t most_columns = 6;  ///< Capacitances cost a solve for each group

const std::string by_multipoles = "multipoles at 1e-13";

void check_request(Contract& contract, const LaplaceProblem& problem, const LaplaceSolution& exact,
                   const AccuracyRequest& request, const FieldGuarantees& guarantees) {
  try {
    const AccurateSolution found = solve_to_accuracy(problem, request);
    guarantees.add(contract, request.accuracy, errors_of(problem, found.solution, exact));
  } catch (const InputError&) {
    contract.refuse(guarantees.potential);
  }
}

void check_disks(Contract& contract, CaseRandom& random) {
  static const FieldGuarantees cut_cells("accuracy, cut cells", by_multipoles),
      multipoles("accuracy, multipoles", by_multipoles), direct("tolerance, multipoles", by_multipoles);
  const LaplaceProblem problem = random_plane(random);
  const LaplaceSolution exact = MultipoleSolver({.tolerance = 1e-13}).solve(problem);
  if (scales_of(problem, exact).potential == 0) return;
  const double coarse = random.pick({3e-2, 1e-2, 1e-2, 3e-3, 1e-3});
  const double fine = random.pick({1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8});
  check_request(contract, problem, exact, {.accuracy = coarse, .method = Method::cut_cell, .most_cells = 1536},
                cut_cells);
  check_request(contract, problem, exact, {.accuracy = fine, .method = Method::multipole}, multipoles);
  MultipoleSolver solver({.tolerance = fine});
  direct.add(contract, fine, errors_of(problem, solver.solve(problem), exact));
  if (problem.groups.size() > most_columns || (!problem.has_ground() && problem.groups.size() == 1)) return;
  MultipoleSolver reference({.tolerance = 1e-13});
  direct.add_capacitances(contract, fine, capacitance_matrix(solver, problem), capacitance_matrix(reference, problem));
}

constexpr int quick_seeds = 5, full_cases = 500;

void check(Contract& contract, std::uint64_t seed) {
  CaseRandom random(seed);
  check_disks(contract, random);
  if ((seed > 1 && seed <= quick_seeds) || seed > full_cases) return;  // a grid of 3072 cells takes seconds
  static const FieldGuarantees other_shapes("accuracy, bars and rings", "cut cells, 3072 along each side");
  const LaplaceProblem problem = random_shapes(random);
  const LaplaceSolution exact = CutCellSolver({.cells = 3072, .tolerance = 1e-10}).solve(problem);
  check_request(contract, problem, exact, {.accuracy = random.pick({3e-2, 1e-2}), .most_cells = 1024}, other_shapes);
}

}  // namespace

int validate(int argc, char** argv) {
  return Contract().run("conductors in the plane", argc, argv, quick_seeds, full_cases, check);
}

const lichtenberg::validation::Program program("contract_plane", validate);

}  // namespace contract_plane_validation
