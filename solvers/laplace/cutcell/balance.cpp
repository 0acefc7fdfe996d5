#include <Eigen/Core>
#include <optional>

#include "solvers/laplace/cutcell/operator.hpp"
#include "solvers/laplace/cutcell/sparse_factors.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// The links to what has a given potential.
struct Ground {
  double flux = 0;               ///< sum of conductance * (given potential - x)
  double conductance = 0;        ///< sum
  std::vector<double> of_group;  ///< conductances of each floating group's own such links
};

Ground links_to_ground(const LaplaceProblem& problem, const Level& level, double scale, const double* x) {
  const double* x_group = x + level.layout.size();
  Ground ground;
  ground.of_group.assign(problem.groups.size(), 0.0);
  const auto add = [&](double conductance, double given, double own) {
    ground.flux += conductance * (given / scale - own);
    ground.conductance += conductance;
  };
  const auto add_to_group = [&](double conductance, double given, int group) {
    if (!problem.groups[group].floating) return;
    add(conductance, given, x_group[group]);
    ground.of_group[group] += conductance;
  };
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const Group& group = problem.groups[problem.bodies[body].group];
    if (group.floating) continue;
    for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m)
      add(level.links[m].conductance, group.potential, x[level.links[m].cell]);
  }
  for (const PairLink& pair : level.pairs) {
    const int a = problem.bodies[pair.body_a].group, b = problem.bodies[pair.body_b].group;
    if (!problem.groups[b].floating) add_to_group(pair.conductance, problem.groups[b].potential, a);
    if (!problem.groups[a].floating) add_to_group(pair.conductance, problem.groups[a].potential, b);
  }
  for (const SideLink& link : level.side_links) {
    if (link.cell >= 0)
      add(link.conductance, link.potential, x[link.cell]);
    else
      add_to_group(link.conductance, link.potential, problem.bodies[link.body].group);
  }
  return ground;
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  const auto size = static_cast<Eigen::Index>(a.size());
  return Eigen::Map<const Eigen::VectorXd>(a.data(), size).dot(Eigen::Map<const Eigen::VectorXd>(b.data(), size));
}

/// What enters the cells, and by how much less if their potentials rise.
struct CellSum {
  double flux = 0, conductance = 0;
};

CellSum given_to_cells(const LaplaceProblem& problem, const Level& level, double scale, const double* x) {
  CellSum sum;
  const auto add = [&](double conductance, double given, std::ptrdiff_t cell) {
    sum.flux += conductance * (given / scale - x[cell]);
    sum.conductance += conductance;
  };
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const Group& group = problem.groups[problem.bodies[body].group];
    if (group.floating) continue;
    for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m)
      add(level.links[m].conductance, group.potential, level.links[m].cell);
  }
  for (const SideLink& link : level.side_links)
    if (link.cell >= 0) add(link.conductance, link.potential, link.cell);
  return sum;
}

}  // namespace

/// Unknowns are a shift of each group and one of everything, the level, which only the links to given potentials
/// notice: the groups' equations, bordered by the sum of all equations. The border is eliminated last.
void CutCellOperator::balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const {
  if (level_->is_coupled()) return balance_coupled(problem, scale, b, x);
  double* x_group = x + cells_;
  std::vector<double> residual(groups_, 0.0);
  links_.add_to_groups(*team_, x, residual.data());
  std::vector<SparseFactors::Entry> entries;
  double charge = 0;
  for (int g = 0; g < static_cast<int>(groups_); ++g) {
    const bool floating = group_diagonal_[g] > 0;
    entries.push_back({g, g, floating ? group_diagonal_[g] : 1.0});
    residual[g] = floating ? residual[g] + b[cells_ + g] - group_diagonal_[g] * x_group[g] : 0.0;
    if (problem.groups[g].floating) charge += problem.groups[g].charge / problem.permittivity / scale;
  }
  for (const GroupPair& pair : pairs_) {
    residual[pair.a] += pair.conductance * x_group[pair.b];
    residual[pair.b] += pair.conductance * x_group[pair.a];
    entries.push_back({std::max(pair.a, pair.b), std::min(pair.a, pair.b), -pair.conductance});
  }
  // Mostly no floating group has a direct link to another, and each stands alone.
  std::optional<SparseFactors> factors;
  if (!pairs_.empty()) factors.emplace(static_cast<int>(groups_), entries);
  const auto solve_groups = [&](std::vector<double> flux) {
    if (factors) return factors->solve(flux);
    for (std::size_t g = 0; g < groups_; ++g) flux[g] /= entries[g].value;
    return flux;
  };

  const Ground ground = links_to_ground(problem, *level_, scale, x);
  std::vector<double> shift = solve_groups(residual);
  // Without a fluid cell the groups' own shifts are all there is, and their sum is right with them.
  if (ground.conductance > 0 && level_->fluid_cells > 0) {
    const std::vector<double> grounded = solve_groups(ground.of_group);
    const double level =
        (charge + ground.flux - dot(ground.of_group, shift)) / (ground.conductance - dot(ground.of_group, grounded));
    shift_cells(level, x);
    for (std::size_t g = 0; g < groups_; ++g) shift[g] += level * (1 - grounded[g]);
  }
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x_group[g] += shift[g];
}

/// Makes the charges exact under couplings, which may be stronger by any factor than all links to the field. The sum of
/// all equations would hold what they carry, and its rounding; so the level comes from the sum of the cells' equations,
/// in which no coupling is. A level of 1 takes a group to 1 - held, what of all that pulls on it pulls to cells. Both
/// shares are sums of positive terms, so that `held` has all its digits where a fixed group coupled by 1e-12 is all
/// that holds.
void CutCellOperator::balance_coupled(const LaplaceProblem& problem, double scale, const double* b, double* x) const {
  double* x_group = x + cells_;
  std::vector<double> to_cells(groups_, 0.0), from_cells(groups_, 0.0), shift(groups_, 0.0);
  links_.add_conductances(*team_, to_cells.data());
  links_.add_to_groups(*team_, x, from_cells.data());
  apply_groups(x, shift.data());
  for (std::size_t g = 0; g < groups_; ++g) shift[g] = group_diagonal_[g] > 0 ? b[cells_ + g] - shift[g] : 0.0;
  group_factors_.solve(shift.data());
  std::vector<double> held = hold_of_groups(problem);
  group_factors_.solve(held.data());

  CellSum cells = given_to_cells(problem, *level_, scale, x);
  for (std::size_t g = 0; g < groups_; ++g) {
    if (group_diagonal_[g] == 0) continue;
    cells.flux += to_cells[g] * (x_group[g] + shift[g]) - from_cells[g];
    cells.conductance += to_cells[g] * held[g];
  }
  const double level = cells.conductance > 0 ? cells.flux / cells.conductance : 0.0;
  if (level != 0) shift_cells(level, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x_group[g] += shift[g] + level * (1 - held[g]);
}

/// Of each floating group, conductances to what has a given potential.
std::vector<double> CutCellOperator::hold_of_groups(const LaplaceProblem& problem) const {
  std::vector<double> hold(groups_, 0.0);
  for (const PairLink& pair : level_->pairs) {
    const int a = problem.bodies[pair.body_a].group, b = problem.bodies[pair.body_b].group;
    if (!problem.groups[b].floating) hold[a] += pair.conductance;
    if (!problem.groups[a].floating) hold[b] += pair.conductance;
  }
  for (const SideLink& link : level_->side_links)
    if (link.body >= 0) hold[problem.bodies[link.body].group] += link.conductance;
  for (const FixedCoupling& coupling : level_->fixed_couplings) hold[coupling.group] += coupling.conductance;
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] == 0) hold[g] = 0;
  return hold;
}

}  // namespace lichtenberg::laplace
