#include "solvers/laplace/spheres/results.hpp"

#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::spheres {

Vec3 force(const double* multipoles, int degree, const double* response, int response_degree) {
  const auto a = to_complex(multipoles, degree), e = to_complex(response, response_degree);
  std::complex<double> across = 0;
  double along = 0;
  for (int l = 1; l <= response_degree; ++l)
    for (int m = -l; m <= l; ++m) {
      if (std::abs(m) < l)
        along += std::sqrt(static_cast<double>(l - m) * (l + m)) * multipoles[at(l - 1, m)] * response[at(l, m)];
      if (m <= l - 2)
        across += std::sqrt(static_cast<double>(l - m) * (l - m - 1)) * std::conj(a[at(l - 1, m + 1)]) * e[at(l, m)];
    }
  return {across.real(), across.imag(), along};
}

namespace {

double face(const SphereProblem& problem, int axis) {
  const Vec3 l = problem.box.lengths;
  return l.x * l.y * l.z / l[axis];
}

/// Sets the charges of electrodes by reciprocity. With side s at 1 V and all else at 0, the empty box has a potential
/// u. The side's charge is -sum of integral sigma u, plus the charge that the sides induce on each other.
void add_side_charges(const SphereProblem& problem, const WallPotential& wall, SphereSolution& solution) {
  std::vector<int> electrode_sides;
  if (!problem.free_space)
    for (int side = 0; side < 6; ++side)
      if (problem.box.sides[side] == Boundary::electrode) electrode_sides.push_back(side);
  if (!electrode_sides.empty())
    for (const double charge : solution.sphere_charge) solution.electrode_charge -= charge;
  const bool opposite = electrode_sides.size() == 2 && electrode_sides[0] / 2 == electrode_sides[1] / 2;
  for (const int side : electrode_sides) {
    double& charge = solution.side_charge[side];
    const int axis = side / 2;
    const double length = problem.box.lengths[axis];
    if (electrode_sides.size() > 1 && !opposite) {
      charge = NAN;
      continue;
    }
    charge = 0;
    if (opposite) charge = problem.permittivity * face(problem, axis) * wall.slope[axis] * (side % 2 == 0 ? -1 : 1);
    for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
      const double height = problem.spheres[i].centre[axis] / length;
      const double share = !opposite ? 1 : side % 2 == 0 ? 1 - height : height;
      charge -= solution.sphere_charge[i] * share;
      if (opposite) charge -= solution.sphere_dipole[i][axis] / length * (side % 2 == 0 ? -1 : 1);
    }
  }
}

}  // namespace

void add_charges_and_forces(const SphereProblem& problem, const std::vector<Site>& sites,
                            const std::vector<double>& multipoles, const ResponseMultipoles& response,
                            const WallPotential& wall, SphereSolution& solution) {
  const double scale = 4 * std::numbers::pi * problem.permittivity;
  const std::vector<int> start = starts(sites), response_start = starts(sites, response.extra_degrees);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const double* a = multipoles.data() + start[i];
    const double radius = sites[i].radius, moment = scale * radius * radius;
    solution.sphere_charge.push_back(scale * radius * a[0]);
    solution.sphere_dipole.push_back({moment * a[at(1, 1)], moment * a[at(1, -1)], moment * a[at(1, 0)]});
    solution.sphere_force.push_back(scale * force(a, sites[i].degree, response.values.data() + response_start[i],
                                                  sites[i].degree + response.extra_degrees));
    solution.energy += 0.5 * solution.sphere_charge[i] * solution.group_potential[problem.spheres[i].group];
    if (problem.free_space)  // Half of the energy of the sphere's surface charge in the uniform field
      solution.energy += 0.5 * (solution.sphere_charge[i] * wall.at(problem.spheres[i].centre) +
                                dot(solution.sphere_dipole[i], wall.slope));
  }
  add_side_charges(problem, wall, solution);
  if (wall.axis < 0) {  // All electrodes have the same potential
    solution.energy += 0.5 * solution.electrode_charge * wall.constant;
    return;
  }
  for (int side = 2 * wall.axis; side < 2 * wall.axis + 2; ++side)
    solution.energy += 0.5 * solution.side_charge[side] * problem.side_potential[side];
}

}  // namespace lichtenberg::laplace::spheres
