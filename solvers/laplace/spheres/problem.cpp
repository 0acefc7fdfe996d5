#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/spheres.hpp"
#include "solvers/neighbours/pairs.hpp"

namespace lichtenberg::laplace {
namespace {

/// Returns for each group whether it, or a group that it is coupled to, has a sphere.
std::vector<char> reached_by_field(const SphereProblem& problem) {
  const std::vector<int> set = coupled_sets(static_cast<int>(problem.groups.size()), problem.couplings);
  std::vector<char> has_sphere(set.size()), reached;
  for (const Sphere& sphere : problem.spheres) has_sphere[set[sphere.group]] = 1;
  for (const int first : set) reached.push_back(has_sphere[first]);
  return reached;
}

/// Returns the sum of the given charges (C); 0 if it is within their rounding.
double net_charge(const SphereProblem& problem) {
  double charge = 0, magnitude = 0;
  for (const Group& group : problem.groups) {
    if (!group.floating) continue;
    charge += group.charge;
    magnitude += std::abs(group.charge);
  }
  return std::abs(charge) > 1e-10 * magnitude ? charge : 0;
}

bool is_periodic(const Box<3>& box) { return box.periodic(0) && box.periodic(1) && box.periodic(2); }

[[noreturn]] void refuse(const std::string& sentence) { throw InputError(sentence); }

bool is_positive(double number) { return number > 0 && std::isfinite(number); }
bool is_finite(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

void check_box(const SphereProblem& problem) {
  for (int k = 0; k < 3; ++k) {
    if (!is_positive(problem.box.lengths[k])) refuse("the lengths of the box must be positive and finite");
    const bool low = problem.box.sides[2 * k] == Boundary::periodic,
               high = problem.box.sides[2 * k + 1] == Boundary::periodic;
    if (low != high)
      refuse(fmt::format("sides {} and {}: an axis is periodic on both its sides or on none", side_names[2 * k],
                         side_names[2 * k + 1]));
  }
  for (int side = 0; side < 6; ++side)
    if (problem.box.sides[side] == Boundary::electrode && !std::isfinite(problem.side_potential[side]))
      refuse(fmt::format("side {}: its potential must be finite", side_names[side]));
}

void check_against_sides(const SphereProblem& problem, std::size_t i) {
  const Sphere& sphere = problem.spheres[i];
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double height = side % 2 == 0 ? sphere.centre[axis] : problem.box.lengths[axis] - sphere.centre[axis];
    if (problem.box.periodic(axis) || height > sphere.radius) continue;
    const bool insulating = problem.box.sides[side] == Boundary::wall;
    if (!insulating && sphere.is_conductor())
      refuse(fmt::format("sphere {} is on or through the side {}: its centre is {:.6g} m from it, its radius {:.6g} m",
                         i, side_names[side], height, sphere.radius));
    // A dielectric at an electrode overlaps its image by twice as much as the side.
    const double deepest = insulating ? deepest_contact : 0.5 * deepest_contact, overlap = 1 - height / sphere.radius;
    if (overlap > deepest)
      refuse(fmt::format("sphere {} is through the side {} by {:.3g} % of its radius: at most {:g} % is allowed", i,
                         side_names[side], 100 * overlap, 100 * deepest));
  }
}

void check_pairs(const SphereProblem& problem) {
  const auto n = problem.spheres.size();
  std::vector<double> position(3 * n), radius(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) position[3 * i + k] = problem.spheres[i].centre[k];
    radius[i] = problem.spheres[i].radius;
  }
  Spheres<3> spheres{position, radius};
  if (!problem.free_space) spheres.box = problem.box;
  for (const Pair& pair : pairs_closer_than(spheres, 0.0)) {
    const Sphere &a = problem.spheres[pair.i], &b = problem.spheres[pair.j];
    const double overlap = a.radius + b.radius - norm(spheres.box.difference(a.centre, b.centre));
    if (a.group != b.group && a.is_conductor() && b.is_conductor())
      refuse(fmt::format("spheres {} and {} touch, but belong to different groups", pair.i, pair.j));
    const double smaller = std::min(a.radius, b.radius);
    if (overlap > deepest_contact * smaller)
      refuse(fmt::format("spheres {} and {} overlap by {:.3g} % of the smaller radius: at most 1 % is allowed", pair.i,
                         pair.j, 100 * overlap / smaller));
  }
}

void check_couplings(const SphereProblem& problem) {
  const int groups = static_cast<int>(problem.groups.size());
  for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
    const auto& [a, b, capacitance] = problem.couplings[k];
    if (std::min(a, b) < 0 || std::max(a, b) >= groups || a == b)
      refuse(fmt::format("coupling {} must join two different groups of 0 to {}, not {} and {}", k, groups - 1, a, b));
    if (!(capacitance >= 0 && std::isfinite(capacitance)))
      refuse(fmt::format("coupling {} must have a finite capacitance that is not negative", k));
  }
}

void check_groups(const SphereProblem& problem) {
  std::vector<int> members(problem.groups.size());
  for (std::size_t i = 0; i < problem.spheres.size(); ++i) {
    const Sphere& sphere = problem.spheres[i];
    if (!is_positive(sphere.radius)) refuse(fmt::format("sphere {}: its radius must be positive and finite", i));
    if (!is_finite(sphere.centre)) refuse(fmt::format("sphere {}: its centre must be finite", i));
    if (sphere.group < 0 || sphere.group >= static_cast<int>(members.size()))
      refuse(fmt::format("sphere {} names group {}, which does not exist", i, sphere.group));
    ++members[sphere.group];
    if (!sphere.is_conductor() && !(sphere.relative_permittivity > 1))
      refuse(fmt::format("sphere {}: its permittivity must be more than that outside", i));
  }
  for (const Sphere& sphere : problem.spheres)
    if (!sphere.is_conductor() && (members[sphere.group] > 1 || !problem.groups[sphere.group].floating))
      refuse(fmt::format("group {}: a dielectric sphere must be alone in a floating group", sphere.group));
  check_couplings(problem);
  const std::vector<char> reached = reached_by_field(problem);
  for (std::size_t g = 0; g < members.size(); ++g) {
    if (!std::isfinite(problem.groups[g].floating ? problem.groups[g].charge : problem.groups[g].potential))
      refuse(fmt::format("group {}: its charge or potential must be finite", g));
    if (problem.groups[g].floating && !reached[g])
      refuse(fmt::format("group {} has no sphere, and is coupled to none that has", g));
  }
  const double charge = net_charge(problem);
  if (!problem.has_ground() && !is_periodic(problem.box) && charge != 0)
    refuse(fmt::format(
        "no side is an electrode and no group has a given potential, so the charges must sum to zero, not {:.6g} C",
        charge));
}

}  // namespace

bool SphereProblem::grounded() const {
  return free_space || std::find(box.sides.begin(), box.sides.end(), Boundary::electrode) != box.sides.end();
}

bool SphereProblem::has_ground() const {
  if (grounded()) return true;
  const std::vector<char> reached = reached_by_field(*this);
  for (std::size_t g = 0; g < groups.size(); ++g)
    if (!groups[g].floating && reached[g]) return true;
  return false;
}

double SphereProblem::neutralized_charge() const {
  return is_periodic(box) && !free_space && !has_ground() ? net_charge(*this) : 0;
}

void SphereProblem::check() const {
  if (!is_positive(permittivity)) refuse("the permittivity must be positive and finite");
  if (!free_space) check_box(*this);
  if (free_space && !is_finite(uniform_field)) refuse("the uniform field must be finite");
  check_groups(*this);
  if (!free_space)
    for (std::size_t i = 0; i < spheres.size(); ++i) check_against_sides(*this, i);
  check_pairs(*this);
}

}  // namespace lichtenberg::laplace
