#include <Eigen/Sparse>

#include "solvers/laplace/cutcell/operator.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The links to what has a given potential.
struct Ground {
  double flux = 0;           ///< sum of conductance * (given potential - x)
  double conductance = 0;    ///< sum
  Eigen::VectorXd of_group;  ///< conductances of each floating group's own such links
};

Ground links_to_ground(const LaplaceProblem& problem, const Level& level, double scale, const double* x) {
  const double* x_group = x + level.layout.size();
  Ground ground;
  ground.of_group = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.groups.size()));
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

}  // namespace

/// Unknowns are a shift of each group and one of everything, the level, which only the links to given potentials
/// notice: the groups' equations, bordered by the sum of all equations. The border is eliminated last.
void CutCellOperator::balance(const LaplaceProblem& problem, double scale, const double* b, double* x) const {
  const auto groups = static_cast<Eigen::Index>(groups_);
  double* x_group = x + cells_;
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(groups);
  links_.add_to_groups(*team_, x, residual.data());
  std::vector<Eigen::Triplet<double>> entries;
  double charge = 0;
  for (Eigen::Index g = 0; g < groups; ++g) {
    const bool floating = group_diagonal_[g] > 0;
    entries.emplace_back(g, g, floating ? group_diagonal_[g] : 1.0);
    residual[g] = floating ? residual[g] + b[cells_ + g] - group_diagonal_[g] * x_group[g] : 0.0;
    if (problem.groups[g].floating) charge += problem.groups[g].charge / problem.permittivity / scale;
  }
  for (const GroupPair& pair : pairs_) {
    residual[pair.a] += pair.conductance * x_group[pair.b];
    residual[pair.b] += pair.conductance * x_group[pair.a];
    entries.emplace_back(std::max(pair.a, pair.b), std::min(pair.a, pair.b), -pair.conductance);
  }
  SparseMatrix matrix(groups, groups);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<SparseMatrix> factors(matrix);

  const Ground ground = links_to_ground(problem, *level_, scale, x);
  Eigen::VectorXd shift = groups > 0 ? Eigen::VectorXd(factors.solve(residual)) : residual;
  if (ground.conductance > 0) {
    const Eigen::VectorXd grounded = groups > 0 ? Eigen::VectorXd(factors.solve(ground.of_group)) : residual;
    const double level =
        (charge + ground.flux - ground.of_group.dot(shift)) / (ground.conductance - ground.of_group.dot(grounded));
    for_each_row(*team_, level_->layout, [&](int j) {
      for (int colour = 0; colour < 2; ++colour) {
        const std::ptrdiff_t row = level_->layout.row(colour, j);
        for (int k = 0; k < level_->layout.row_length(colour, j); ++k)
          if (level_->diagonal[row + k] > 0) x[row + k] += level;
      }
    });
    for (Eigen::Index g = 0; g < groups; ++g) shift[g] += level * (1 - grounded[g]);
  }
  for (Eigen::Index g = 0; g < groups; ++g)
    if (group_diagonal_[g] > 0) x_group[g] += shift[g];
}

}  // namespace lichtenberg::laplace
