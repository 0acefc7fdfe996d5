#pragma once

#include <memory>
#include <vector>

namespace lichtenberg::laplace {

/// LDL^T factors of a sparse symmetric matrix in double precision. They are Eigen's, whose headers take seconds to
/// compile and are met in this class's source file alone.
class SparseFactors {
 public:
  struct Entry {
    int row, column;
    double value;
  };

  SparseFactors();
  /// Entries of the lower triangle, [size, size]; what is above it is not read. Those at the same place are added.
  SparseFactors(int size, const std::vector<Entry>& entries);
  SparseFactors(SparseFactors&&) noexcept;
  SparseFactors& operator=(SparseFactors&&) noexcept;
  ~SparseFactors();

  /// Whether the matrix is positive definite: then all pivots are positive.
  bool are_positive() const;
  /// The solution for a right-hand side [size]; of a matrix of no size, nothing.
  std::vector<double> solve(const std::vector<double>& rhs) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace lichtenberg::laplace
