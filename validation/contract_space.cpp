// Accuracy contract of the field of conducting spheres: random scenes of 1 to 75 spheres with gaps from 1e-5 radii.
// They have a requested accuracy (field.accuracy), a tolerance, and a tolerance in a moving scene. The reference of
// pairs is the bispherical series; that of other scenes is a solution at 1 % of the requested error. Narrow gaps do not
// permit less than 1e-10.
//
//   contract_space              a few cases: seconds
//   contract_space long         500 cases of each guarantee
//   contract_space FROM TO      the cases of these seeds

#include <numbers>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/accuracy.hpp"
#include "validation/contract_scenes.hpp"
#include "validation/program.hpp"
#include "validation/theory/two_spheres.hpp"

namespace contract_space_validation {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::validation;

namespace {

SphereProblem random_space(CaseRandom& random) {
  const int count = static_cast<int>(random.pick({1, 2, 3, 5, 10, 30, 60, 75}));
  const auto kind = static_cast<GroupKind>(random.whole(0, 2));
  const bool narrow = count <= 10 && random.chance(0.5);
  const Packing packing =
      random_packing(random, 3, count, narrow ? random.logarithmic(1e-5, 0.03) : random.logarithmic(0.03, 1));
  SphereProblem problem{.permittivity = permittivity_of_oil};
  problem.box.lengths = {packing.size[0], packing.size[1], packing.size[2]};
  const double potential = random.logarithmic(5, 2000), sides = random.uniform(0, 1);
  problem.free_space = kind != GroupKind::neutral && sides < 0.3;
  const auto hold = [&](int side, double value) {
    problem.box.sides[side] = Boundary::electrode;
    problem.side_potential[side] = value;
  };
  if (kind == GroupKind::neutral || sides > 0.6)  // two plates
    hold(0, 0), hold(1, potential);
  else
    for (int side = 0; side < 6; ++side)
      if (random.chance(0.3)) hold(side, potential);
  const double unit = permittivity_of_oil * packing.radii[0] * random.logarithmic(10, 1000);
  add_bodies(problem, packing, random, kind, unit, [&](std::size_t i, int group) {
    const auto& centre = packing.centres[i];
    problem.spheres.push_back({{centre[0], centre[1], centre[2]}, packing.radii[i], group});
  });
  problem.movable = free_first(problem.spheres, problem.groups);
  return problem;
}

FieldErrors errors_of(const SphereProblem& problem, const SphereSolution& found, const SphereSolution& exact) {
  const Scales scales = scales_of(problem, exact);
  FieldErrors errors;
  for (std::size_t g = 0; g < exact.group_potential.size(); ++g)
    errors.potential =
        larger(errors.potential, std::abs(found.group_potential[g] - exact.group_potential[g]) / scales.potential);
  for (std::size_t i = 0; i < exact.sphere_charge.size(); ++i) {
    errors.charge =
        larger(errors.charge, scales.error_of_charge(std::abs(found.sphere_charge[i] - exact.sphere_charge[i])));
    if (static_cast<int>(i) < problem.movable)
      errors.force = larger(errors.force, scales.error_of_force(norm(found.sphere_force[i] - exact.sphere_force[i])));
  }
  errors.energy = std::abs(found.energy / exact.energy - 1);
  return errors;
}

SphereSolution exact_for(const SphereProblem& problem, double requested) {
  return SphereSolver({.accuracy = std::max(1e-2 * requested, 1e-10)}).solve(problem);
}

const std::string by_finer = "the same method at 1e-2 of the request";

/// Moves each sphere by at most 5 % of the smallest gap, and at most 1 % of the smallest radius.
void move(SphereProblem& problem, CaseRandom& random) {
  double reach = INFINITY;
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const Sphere& one = problem.spheres[i];
    reach = std::min(reach, 0.01 * one.radius);
    for (int k = 0; k < 3 && !problem.free_space; ++k)
      reach = std::min(reach, 0.05 * (std::min(one.centre[k], problem.box.lengths[k] - one.centre[k]) - one.radius));
    for (std::size_t j = 0; j < i; ++j) {
      const Sphere& other = problem.spheres[j];
      reach = std::min(reach, 0.05 * (norm(one.centre - other.centre) - one.radius - other.radius));
    }
  }
  for (Sphere& sphere : problem.spheres)
    for (int k = 0; k < 3; ++k) sphere.centre[k] += reach * random.uniform(-0.5, 0.5);
}

/// Solves a scene at a tolerance, and again after each of three displacements, from the solutions before.
void check_tolerance(Contract& contract, SphereProblem problem, CaseRandom& random) {
  static const FieldGuarantees rest("tolerance, spheres", by_finer), motion("moving tolerance, spheres", by_finer);
  const double tolerance = random.logarithmic(1e-8, 1e-1);
  SphereSolver solver({.accuracy = tolerance});
  try {
    const SphereSolution found = solver.solve(problem), exact = exact_for(problem, tolerance);
    if (scales_of(problem, exact).potential == 0) return;
    rest.add(contract, tolerance, errors_of(problem, found, exact));
    constexpr std::size_t most_columns = 12;
    if (problem.groups.size() <= most_columns && (problem.has_ground() || problem.groups.size() > 1))
      rest.add_capacitances(contract, tolerance, SphereSolver({.accuracy = tolerance}).capacitance_matrix(problem),
                            SphereSolver({.accuracy = std::max(1e-2 * tolerance, 1e-10)}).capacitance_matrix(problem));
  } catch (const InputError&) {  // a gap needs more harmonics than there are
    contract.refuse(rest.potential);
    return;
  }
  SphereSolution found;
  for (int step = 0; step < 3; ++step) {
    move(problem, random);
    found = solver.solve(problem);
  }
  motion.add(contract, tolerance, errors_of(problem, found, exact_for(problem, tolerance)));
}

/// Two spheres in free space in a random direction, each with a given charge or potential.
struct RandomPair {
  SphereProblem problem{.free_space = true, .permittivity = permittivity_of_oil, .movable = 2};
  SphereSolution exact;
  std::vector<double> capacitances;

  explicit RandomPair(CaseRandom& random) {
    const double a = random.logarithmic(3e-4, 1e-3), b = a / random.logarithmic(1, 30);
    Vec3 axis{random.normal(), random.normal(), random.normal()};
    axis = axis * (1 / norm(axis));
    const Vec3 centre = axis * (a + b + b * random.logarithmic(1e-5, 3));
    problem.spheres = {{{}, a, 0}, {centre, b, 1}};
    const double scale = 4 * std::numbers::pi * permittivity_of_oil;
    const theory::SphereCapacitances c = theory::sphere_capacitances(a, b, norm(centre));
    std::array<bool, 2> floating{};
    std::array<double, 2> given{};
    for (int i = 0; i < 2; ++i) {
      floating[i] = random.chance(0.5), given[i] = random.uniform(-1000, 1000);
      if (floating[i]) given[i] *= b;
      problem.groups.push_back({.floating = floating[i],
                                .charge = floating[i] ? scale * given[i] : 0,
                                .potential = floating[i] ? 0 : given[i]});
    }
    const theory::SpherePair pair = theory::sphere_pair(c, floating, given);
    exact.group_potential = {pair.potential[0], pair.potential[1]};
    exact.sphere_charge = {scale * pair.charge[0], scale * pair.charge[1]};
    exact.sphere_force = {axis * (-scale * pair.force), axis * (scale * pair.force)};
    exact.energy = scale * pair.energy;
    for (const double value : {c.own_first, c.mutual, c.mutual, c.own_second}) capacitances.push_back(scale * value);
  }
};

void check_pair(Contract& contract, CaseRandom& random) {
  static const FieldGuarantees guarantees("tolerance, two spheres", "bispherical series");
  const RandomPair pair(random);
  const double tolerance = random.logarithmic(1e-9, 1e-1);
  SphereSolver solver({.accuracy = tolerance});
  try {
    guarantees.add(contract, tolerance, errors_of(pair.problem, solver.solve(pair.problem), pair.exact));
    guarantees.add_capacitances(contract, tolerance, solver.capacitance_matrix(pair.problem), pair.capacitances);
  } catch (const InputError&) {  // a gap needs more harmonics than there are
    contract.refuse(guarantees.potential);
  }
}

void check(Contract& contract, std::uint64_t seed) {
  CaseRandom pair(seed, 1);
  check_pair(contract, pair);
  CaseRandom random(seed);
  const SphereProblem problem = random_space(random);
  check_tolerance(contract, problem, random);
  static const FieldGuarantees requested("accuracy, spheres", by_finer);
  const double accuracy = random.logarithmic(1e-6, 1e-1);
  try {
    const AccurateSpheres found =
        solve_to_accuracy(problem, accuracy, [](double tolerance) { return SphereSolver({.accuracy = tolerance}); });
    const SphereSolution exact = exact_for(problem, std::min(accuracy, found.tolerance));
    if (scales_of(problem, exact).potential != 0)
      requested.add(contract, accuracy, errors_of(problem, found.solution, exact));
  } catch (const InputError&) {
    contract.refuse(requested.potential);
  }
}

}  // namespace

int validate(int argc, char** argv) { return Contract().run("conducting spheres in space", argc, argv, 6, 500, check); }

const lichtenberg::validation::Program program("contract_space", validate);

}  // namespace contract_space_validation
