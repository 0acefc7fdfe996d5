#include "solvers/laplace/cutcell/sparse_factors.hpp"

#include <Eigen/SparseCholesky>

namespace lichtenberg::laplace {

struct SparseFactors::Factors {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
};

SparseFactors::SparseFactors() = default;
SparseFactors::SparseFactors(SparseFactors&&) noexcept = default;
SparseFactors& SparseFactors::operator=(SparseFactors&&) noexcept = default;
SparseFactors::~SparseFactors() = default;

SparseFactors::SparseFactors(int size, const std::vector<Entry>& entries) {
  if (size == 0) return;
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(entries.size());
  for (const auto& [row, column, value] : entries) triplets.emplace_back(row, column, value);
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  factors_ = std::make_unique<Factors>();
  factors_->solver.compute(matrix);
}

bool SparseFactors::are_positive() const {
  return !factors_ || (factors_->solver.info() == Eigen::Success && factors_->solver.vectorD().minCoeff() > 0);
}

std::vector<double> SparseFactors::solve(const std::vector<double>& rhs) const {
  std::vector<double> solution(rhs.size());
  if (!factors_) return solution;
  const auto size = static_cast<Eigen::Index>(rhs.size());
  Eigen::Map<Eigen::VectorXd>(solution.data(), size) =
      factors_->solver.solve(Eigen::Map<const Eigen::VectorXd>(rhs.data(), size));
  return solution;
}

}  // namespace lichtenberg::laplace
