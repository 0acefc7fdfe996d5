#include "solvers/laplace/problem.hpp"

#include <cmath>
#include <sstream>
#include <string>

#include "solvers/error.hpp"

namespace lichtenberg::laplace {
namespace {

bool positive(double x) { return std::isfinite(x) && x > 0; }
bool finite(Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); }

bool well_formed(const Disk& disk) { return finite(disk.centre) && positive(disk.radius); }
bool well_formed(const Ring& ring) { return finite(ring.centre) && positive(ring.radius); }
bool well_formed(const Bar& bar) {
  return finite(bar.from) && finite(bar.to) && positive(norm(bar.to - bar.from)) && positive(bar.width);
}

void check_box(const LaplaceProblem& problem) {
  if (!positive(problem.size.x) || !positive(problem.size.y))
    throw InputError("the field's box must have a positive, finite width and height");
  if (!positive(problem.permittivity)) throw InputError("the permittivity must be positive and finite");
  for (const Side& side : problem.sides) {
    if (side.profile && side.kind == Side::Kind::insulating)
      throw InputError("a side of the box with a potential profile must be an electrode, not insulating");
    if (!std::isfinite(side.potential)) throw InputError("the potential of a side of the box must be finite");
  }
}

void check_bodies(const LaplaceProblem& problem) {
  const int groups = static_cast<int>(problem.groups.size());
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const Body& body = problem.bodies[b];
    const std::string name = "body " + std::to_string(b);
    if (body.group < 0 || body.group >= groups)
      throw InputError(name + " names group " + std::to_string(body.group) + ", but there are groups 0 to " +
                       std::to_string(groups - 1) + " only");
    if (!std::visit([](const auto& shape) { return well_formed(shape); }, body.shape))
      throw InputError(name + " must have a finite position and a positive size");
  }
}

void check_groups(const LaplaceProblem& problem) {
  std::vector<int> members(problem.groups.size());
  for (const Body& body : problem.bodies) ++members[body.group];
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const Group& group = problem.groups[g];
    const std::string name = "group " + std::to_string(g);
    if (!std::isfinite(group.floating ? group.charge : group.potential))
      throw InputError(name + " must have a finite charge or potential");
    if (group.floating && members[g] == 0) throw InputError(name + " floats but has no body to carry its charge");
  }
}

void check_neutral(const LaplaceProblem& problem) {
  double total = 0, sum_of_magnitudes = 0;
  for (const Group& group : problem.groups) {
    total += group.charge;
    sum_of_magnitudes += std::abs(group.charge);
  }
  // Charges that cancel on paper are summed with rounding, and may come from a long run's bookkeeping.
  constexpr double rounding = 1e-10;
  if (std::abs(total) <= rounding * sum_of_magnitudes) return;
  std::ostringstream share;
  share << total / sum_of_magnitudes;  // std::to_string would make 0.000000 of a small one
  throw InputError("the box is insulated and nothing is grounded, so the charges must sum to zero, but they sum to " +
                   share.str() + " of their magnitudes");
}

}  // namespace

bool LaplaceProblem::has_ground() const {
  for (const Side& side : sides)
    if (side.kind == Side::Kind::electrode) return true;
  for (const Body& body : bodies)
    if (!groups[body.group].floating) return true;
  return false;
}

void LaplaceProblem::check() const {
  check_box(*this);
  check_bodies(*this);
  check_groups(*this);
  if (!has_ground()) check_neutral(*this);
}

std::vector<double> capacitance_matrix(LaplaceSolver& solver, const LaplaceProblem& problem) {
  const std::size_t n = problem.groups.size();
  LaplaceProblem unit = problem;
  for (Side& side : unit.sides) {
    side.potential = 0;
    side.profile = nullptr;
  }
  for (Group& group : unit.groups) group = {.floating = false};

  std::vector<double> capacitance(n * n);
  for (std::size_t j = 0; j < n; ++j) {
    unit.groups[j].potential = 1;
    const LaplaceSolution solution = solver.solve(unit);
    unit.groups[j].potential = 0;
    for (std::size_t b = 0; b < unit.bodies.size(); ++b)
      capacitance[unit.bodies[b].group * n + j] += solution.body_charge[b];
  }
  return capacitance;
}

}  // namespace lichtenberg::laplace
