#include "solvers/laplace/cutcell/level_sums.hpp"
#include "solvers/laplace/cutcell/operator.hpp"

namespace lichtenberg::laplace {

/// Solves a small system for a shift of each group and one common shift of all potentials, the level. A level of 1
/// shifts a group by 1 - response only, where `response` stems from its links to given potentials. The sum of the
/// cells' equations determines the level. The sum of all equations would contain the flux through couplings and its
/// rounding error, which may exceed all flux to the field. `response` is a sum of positive terms and therefore accurate
/// also for a single fixed group coupled by 1e-12.
void CutCellOperator::balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const {
  double* x_group = x + cells_;
  std::vector<double> to_cells(groups_, 0.0), from_cells(groups_, 0.0), shift(groups_, 0.0);
  links_.add_conductances(*team_, to_cells.data());
  links_.add_to_groups(*team_, x, from_cells.data());
  const Layout& at = level_->layout;
  for (std::vector<double>* sum : {&to_cells, &from_cells}) add_over_slabs(at, sum->data(), std::ssize(*sum));
  apply_groups(x, shift.data());
  for (std::size_t g = 0; g < groups_; ++g) shift[g] = group_diagonal_[g] > 0 ? b[cells_ + g] - shift[g] : 0.0;
  solve_groups(shift.data());
  std::vector<double> response(groups_, 0.0);
  LevelSums sums;
  for_each_given(
      problem, *level_,
      [&](std::ptrdiff_t cell, double c, double given) {
        if (at.owns(cell)) sums += LevelSums::from_link(c, given / scale, x[cell]);
      },
      [&](int g, double c, double) { response[g] += group_diagonal_[g] > 0 ? c : 0.0; });
  add_over_slabs(at, response.data(), std::ssize(response));
  sums = {sum_over_slabs(at, sums.flux), sum_over_slabs(at, sums.conductance)};
  solve_groups(response.data());
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0)
      sums += LevelSums::from_group(to_cells[g], x_group[g] + shift[g], from_cells[g], response[g]);
  const double level = sums.level();
  if (level != 0) shift_cells(level, x);
  for (std::size_t g = 0; g < groups_; ++g)
    if (group_diagonal_[g] > 0) x_group[g] += shift[g] + level * (1 - response[g]);
}

/// Solves the groups' equations for constant potentials of the cells: replaces the flux into each group (bodies with
/// one potential) by the group's potential.
void CutCellOperator::solve_groups(double* flow) const {
  if (are_linked()) return group_factors_.solve(flow);
  for (std::size_t g = 0; g < groups_; ++g) flow[g] = group_diagonal_[g] > 0 ? flow[g] / group_diagonal_[g] : 0.0;
}

}  // namespace lichtenberg::laplace
