#include "solvers/laplace/cutcell/level_sums.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

namespace {

/// Of the links of cells to given potentials.
LevelSums given_to_cells(const LaplaceProblem& problem, const Level& level, double scale, const double* x) {
  LevelSums sums;
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const Group& group = problem.groups[problem.bodies[body].group];
    if (group.floating) continue;
    for (int m = level.link_start[body]; m < level.link_start[body + 1]; ++m)
      sums += LevelSums::of_link(level.links[m].conductance, group.potential / scale, x[level.links[m].cell]);
  }
  for (const SideLink& link : level.side_links)
    if (link.cell >= 0) sums += LevelSums::of_link(link.conductance, link.potential / scale, x[link.cell]);
  return sums;
}

}  // namespace

/// Unknowns are a shift of each group and one of everything, the level. A level of 1 takes a group to 1 - held, since
/// links to given potentials (`hold`) pull on it as well as links to cells. The level comes from the sum of the cells'
/// equations: the sum of all equations would hold what couplings carry, which may be stronger by any factor than all
/// links to the field, and its rounding. `held` is a sum of positive terms, so that it has all its digits where a
/// fixed group coupled by 1e-12 is all that holds.
void CutCellOperator::balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const {
  double* x_group = x + cells_;
  std::vector<double> to_cells(groups_, 0.0), from_cells(groups_, 0.0), shift(groups_, 0.0);
  links_.add_conductances(*team_, to_cells.data());
  links_.add_to_groups(*team_, x, from_cells.data());
  apply_groups(x, shift.data());
  for (std::size_t g = 0; g < groups_; ++g) shift[g] = group_diagonal_[g] > 0 ? b[cells_ + g] - shift[g] : 0.0;
  solve_groups(shift.data());
  std::vector<double> held = hold_of_groups(problem);
  solve_groups(held.data());

  LevelSums sums = given_to_cells(problem, *level_, scale, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) sums += LevelSums::of_group(to_cells[g], x_group[g] + shift[g], from_cells[g], held[g]);
  const double level = sums.level();
  if (level != 0) shift_cells(level, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x_group[g] += shift[g] + level * (1 - held[g]);
}

/// From what flows into each group to its potential, for given potentials of the cells.
void CutCellOperator::solve_groups(double* flow) const {
  if (are_linked()) return group_factors_.solve(flow);
  for (std::size_t g = 0; g < groups_; ++g) flow[g] = group_diagonal_[g] > 0 ? flow[g] / group_diagonal_[g] : 0.0;
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
