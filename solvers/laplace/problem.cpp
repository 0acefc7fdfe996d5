#include "solvers/laplace/problem.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"

namespace lichtenberg::laplace {
namespace {

bool positive(double x) { return std::isfinite(x) && x > 0; }
bool finite(Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); }

bool well_formed(const Disk& disk) { return finite(disk.centre) && positive(disk.radius); }
bool well_formed(const Ring& ring) { return finite(ring.centre) && positive(ring.radius); }
bool well_formed(const Freeform& shape) { return shape.curve != nullptr; }
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

/// Returns for each group whether it has a body. Throws InputError for a body without a group, position or size.
std::vector<char> check_bodies(const LaplaceProblem& problem) {
  const int groups = static_cast<int>(problem.groups.size());
  std::vector<char> has_body(problem.groups.size());
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const Body& body = problem.bodies[b];
    if (body.group < 0 || body.group >= groups)
      throw InputError("body " + std::to_string(b) + " names group " + std::to_string(body.group) +
                       ", but there are groups 0 to " + std::to_string(groups - 1) + " only");
    const auto* disk = std::get_if<Disk>(&body.shape);
    if (!(disk ? well_formed(*disk) : std::visit([](const auto& shape) { return well_formed(shape); }, body.shape)))
      throw InputError("body " + std::to_string(b) + " must have a finite position and a positive size");
    has_body[body.group] = true;
  }
  return has_body;
}

std::vector<char> groups_with_bodies(const LaplaceProblem& problem) {
  std::vector<char> has_body(problem.groups.size());
  for (const Body& body : problem.bodies) has_body[body.group] = true;
  return has_body;
}

void check_groups(const LaplaceProblem& problem) {
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const Group& group = problem.groups[g];
    if (!std::isfinite(group.floating ? group.charge : group.potential))
      throw InputError("group " + std::to_string(g) + " must have a finite charge or potential");
  }
}

void check_couplings(const LaplaceProblem& problem) {
  const int groups = static_cast<int>(problem.groups.size());
  for (std::size_t k = 0; k < problem.couplings.size(); ++k) {
    const auto& [a, b, capacitance] = problem.couplings[k];
    const std::string name = "coupling " + std::to_string(k);
    if (std::min(a, b) < 0 || std::max(a, b) >= groups || a == b)
      throw InputError(name + " must join two different groups between 0 and " + std::to_string(groups - 1) + ", not " +
                       std::to_string(a) + " and " + std::to_string(b));
    if (!std::isfinite(capacitance) || capacitance < 0)
      throw InputError(name + " must have a finite capacitance that is not negative");
  }
}

/// Contents of a set of coupled groups, at the index of its first group.
struct SetContents {
  bool has_body = false, has_fixed = false;
};

std::vector<SetContents> contents(const LaplaceProblem& problem, const std::vector<char>& has_body,
                                  const std::vector<int>& set_of) {
  std::vector<SetContents> sets(problem.groups.size());
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    SetContents& set = sets[set_of[g]];
    set.has_body |= has_body[g] != 0;
    set.has_fixed |= !problem.groups[g].floating;
  }
  return sets;
}

bool has_electrode_side(const LaplaceProblem& problem) {
  return std::ranges::any_of(problem.sides, [](const Side& side) { return side.kind == Side::Kind::electrode; });
}

bool has_ground(const LaplaceProblem& problem, const std::vector<SetContents>& sets) {
  return has_electrode_side(problem) ||
         std::ranges::any_of(sets, [](SetContents set) { return set.has_body && set.has_fixed; });
}

void check_carriers(const LaplaceProblem& problem, const std::vector<int>& set_of,
                    const std::vector<SetContents>& sets) {
  for (std::size_t g = 0; g < problem.groups.size(); ++g)
    if (const auto& [has_body, has_fixed] = sets[set_of[g]]; !has_body && !has_fixed)
      throw InputError("group " + std::to_string(g) +
                       " floats but has no body to carry its charge, and is coupled to none");
}

/// Throws InputError unless the charges sum to zero. Sets of coupled groups without a body take their charge from their
/// fixed groups.
void check_neutral(const LaplaceProblem& problem, const std::vector<int>& set_of,
                   const std::vector<SetContents>& sets) {
  double total = 0, sum_of_magnitudes = 0;
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    if (!problem.groups[g].floating || !sets[set_of[g]].has_body) continue;
    total += problem.groups[g].charge;
    sum_of_magnitudes += std::abs(problem.groups[g].charge);
  }
  // Exactly cancelling charges are summed with rounding, and may have accumulated rounding errors of a long run.
  constexpr double rounding = 1e-10;
  if (std::abs(total) <= rounding * sum_of_magnitudes) return;
  std::ostringstream share;
  share << total / sum_of_magnitudes;  // std::to_string would print a small share as 0.000000
  throw InputError("the box is insulated and nothing is grounded, so the charges must sum to zero, but they sum to " +
                   share.str() + " of their magnitudes");
}

}  // namespace

bool LaplaceProblem::has_fixed_conductor() const {
  return has_electrode_side(*this) ||
         std::any_of(bodies.begin(), bodies.end(), [this](const Body& body) { return !groups[body.group].floating; });
}

bool LaplaceProblem::has_ground() const {
  if (has_fixed_conductor()) return true;
  return laplace::has_ground(*this, contents(*this, groups_with_bodies(*this), coupled_sets(*this)));
}

void LaplaceProblem::check() const {
  check_box(*this);
  const std::vector<char> has_body = check_bodies(*this);
  check_groups(*this);
  check_couplings(*this);
  const std::vector<int> set_of = coupled_sets(*this);
  const std::vector<SetContents> sets = contents(*this, has_body, set_of);
  check_carriers(*this, set_of, sets);
  if (!laplace::has_ground(*this, sets)) check_neutral(*this, set_of, sets);
}

std::vector<int> coupled_sets(const LaplaceProblem& problem, double least) {
  return coupled_sets(static_cast<int>(problem.groups.size()), problem.couplings, least);
}

std::vector<int> coupled_sets(int groups, std::span<const Coupling> couplings, double least) {
  std::vector<int> first(groups);
  std::iota(first.begin(), first.end(), 0);
  if (couplings.empty()) return first;
  DisjointSets sets(groups);
  for (const Coupling& coupling : couplings)
    if (coupling.capacitance > least) sets.unite(coupling.a, coupling.b);
  for (int& set : first) set = sets.find(set);
  return first;
}

void refuse_couplings(const LaplaceProblem& problem, const std::string& method) {
  if (problem.couplings.empty()) return;
  throw InputError(method +
                   " cannot solve for resistors between conductors or before an electrode: use the cut-cell method");
}

void refuse_link_models(const LaplaceProblem& problem, const std::string& method) {
  for (const Body& body : problem.bodies)
    if (body.link_model)
      throw InputError(method + " cannot solve for bodies with a link model: use the cut-cell method on the CPU");
}

void refuse_curves(const LaplaceProblem& problem, const std::string& method) {
  for (const Body& body : problem.bodies)
    if (std::holds_alternative<Freeform>(body.shape))
      throw InputError(
          method +
          " cannot solve for electrodes of shape polygon, ellipse or curve: use the cut-cell method on the "
          "CPU");
}

std::vector<double> capacitance_matrix(LaplaceSolver& solver, const LaplaceProblem& problem) {
  const std::size_t n = problem.groups.size();
  LaplaceProblem unit = problem;
  for (Side& side : unit.sides) {
    side.potential = 0;
    side.profile = nullptr;
  }
  for (Group& group : unit.groups) group = {.floating = false};
  unit.couplings.clear();

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
