#include "solvers/laplace/cutcell/history.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace lichtenberg::laplace {

/// Past potentials as a vector of the present geometry: uncovered cells have their conductor's last potential, a new
/// group the mean of its members'.
std::vector<double> History::on_unknowns(const LaplaceProblem& problem, const CutCellOperator& op, const Past& past) {
  const std::size_t cells = past.cell.size();
  std::vector<double> v(op.size(), 0.0);
  std::copy(past.cell.begin(), past.cell.end(), v.begin());
  std::vector<int> members(problem.groups.size(), 0);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    v[cells + problem.bodies[body].group] += past.body[body];
    ++members[problem.bodies[body].group];
  }
  for (std::size_t g = 0; g < members.size(); ++g)
    if (members[g] > 0) v[cells + g] /= members[g];
  op.mask(v.data());
  return v;
}

/// The combination of the last solutions that is closest to the new one in the energy norm (a Galerkin projection with
/// the new operator; Fischer 1998). For a scene in motion that is extrapolation in time, whatever the steps were.
/// Returns the work.
double History::first_guess(const LaplaceProblem& problem, const CutCellOperator& op, const std::vector<double>& b,
                            std::vector<double>& x) const {
  std::fill(x.begin(), x.end(), 0.0);
  if (past_.empty()) return 0.0;
  const auto n = static_cast<Eigen::Index>(op.size());
  // The newest solution and successive differences: nearly orthogonal where the solutions are nearly parallel.
  std::vector<std::vector<double>> basis, image;
  for (std::size_t p = 0; p < past_.size(); ++p) {
    basis.push_back(on_unknowns(problem, op, past_[p == 0 ? 0 : p - 1]));
    if (p > 0) {
      const std::vector<double> older = on_unknowns(problem, op, past_[p]);
      for (std::size_t k = 0; k < op.size(); ++k) basis[p][k] -= older[k];
    }
    image.emplace_back(op.size());
    op.apply(basis[p].data(), image[p].data());
  }
  const auto dot = [n](const std::vector<double>& v, const std::vector<double>& w) {
    return Eigen::Map<const Eigen::VectorXd>(v.data(), n).dot(Eigen::Map<const Eigen::VectorXd>(w.data(), n));
  };
  const std::size_t m = past_.size();
  std::vector<double> gram(m * m), projection(m);
  for (std::size_t p = 0; p < m; ++p) {
    for (std::size_t q = 0; q <= p; ++q) gram[p * m + q] = gram[q * m + p] = dot(basis[p], image[q]);
    projection[p] = dot(basis[p], b);
  }
  const std::vector<double> alpha = closest_combination(gram, projection);
  Eigen::Map<Eigen::VectorXd> guess(x.data(), n);
  for (std::size_t p = 0; p < m; ++p) guess += alpha[p] * Eigen::Map<const Eigen::VectorXd>(basis[p].data(), n);
  return static_cast<double>(past_.size());
}

std::vector<double> closest_combination(const std::vector<double>& gram_by_rows, const std::vector<double>& products) {
  const auto m = static_cast<Eigen::Index>(products.size());
  const Eigen::Map<const Eigen::MatrixXd> gram(gram_by_rows.data(), m, m);
  const Eigen::Map<const Eigen::VectorXd> projection(products.data(), m);
  // Scaled to unit diagonal, a direction that is all but dependent on the others is left out by the pivoting.
  const Eigen::VectorXd unit = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * gram * unit.asDiagonal();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-10);
  solver.compute(scaled);
  const Eigen::VectorXd alpha = unit.cwiseProduct(solver.solve(unit.cwiseProduct(projection)));
  return {alpha.begin(), alpha.end()};
}

void History::remember(const Level& level, const std::vector<double>& x, std::vector<double> body_potential) {
  Past past;
  if (past_.size() == length) {
    past = std::move(past_.back());
    past_.pop_back();
  }
  past.cell.assign(x.begin(), x.begin() + level.layout.size());
  past.body = std::move(body_potential);
  for (const std::ptrdiff_t slot : level.covered) past.cell[slot] = past.body[level.cover[slot]];
  past_.push_front(std::move(past));
}

}  // namespace lichtenberg::laplace
