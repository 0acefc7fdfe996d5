#include "solvers/laplace/multipole/krylov.hpp"

#include <sstream>
#include <unsupported/Eigen/IterativeSolvers>

#include "solvers/error.hpp"
#include "solvers/laplace/multipole/system.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace::multipole {
class SystemMatrix;
}  // namespace lichtenberg::laplace::multipole

template <>
struct Eigen::internal::traits<lichtenberg::laplace::multipole::SystemMatrix> : traits<Eigen::SparseMatrix<double>> {};

namespace lichtenberg::laplace::multipole {

/// Adapter with the interface that Eigen's solvers require of a matrix known only by its products.
class SystemMatrix : public Eigen::EigenBase<SystemMatrix> {
 public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  explicit SystemMatrix(const System& system) : system_(&system) {}
  Eigen::Index rows() const { return system_->size(); }
  Eigen::Index cols() const { return system_->size(); }
  const System& system() const { return *system_; }
  template <class Right>
  Eigen::Product<SystemMatrix, Right, Eigen::AliasFreeProduct> operator*(const Eigen::MatrixBase<Right>& x) const {
    return {*this, x.derived()};
  }

 private:
  const System* system_;
};

namespace {

class SystemPreconditioner {
 public:
  template <class Matrix>
  SystemPreconditioner& analyzePattern(const Matrix&) {
    return *this;
  }
  template <class Matrix>
  SystemPreconditioner& factorize(const Matrix&) {
    return *this;
  }
  template <class Matrix>
  SystemPreconditioner& compute(const Matrix& matrix) {
    system_ = &matrix.system();
    return *this;
  }
  Eigen::VectorXd solve(const Eigen::VectorXd& r) const { return system_->precondition(r); }
  Eigen::ComputationInfo info() const { return Eigen::Success; }

 private:
  const System* system_ = nullptr;
};

}  // namespace
}  // namespace lichtenberg::laplace::multipole

namespace Eigen::internal {

template <class Right>
struct generic_product_impl<lichtenberg::laplace::multipole::SystemMatrix, Right, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<lichtenberg::laplace::multipole::SystemMatrix, Right,
                                generic_product_impl<lichtenberg::laplace::multipole::SystemMatrix, Right>> {
  template <class Result>
  static void scaleAndAddTo(Result& result, const lichtenberg::laplace::multipole::SystemMatrix& matrix, const Right& x,
                            double alpha) {
    lichtenberg::stop_if_requested();
    result.noalias() += alpha * (matrix.system() * x);
  }
};

}  // namespace Eigen::internal

namespace lichtenberg::laplace::multipole {

KrylovResult solve_krylov(const System& system, const Eigen::VectorXd& right_hand_side, double tolerance,
                          Eigen::VectorXd& x) {
  constexpr int most_iterations = 1000;
  const double scale = system.precondition(right_hand_side).norm();
  if (scale == 0) {
    x.setZero();
    return {};
  }
  const double first = x.isZero(0) ? scale : system.precondition(right_hand_side - system * x).norm();
  if (first <= tolerance * scale) return {0, first / scale, scale};
  // Number of directions kept: at most 512 MiB of them. With preconditioned charges, which need fewer iterations, it is
  // smaller, since Eigen initializes memory for all of them at the start.
  const int restart = std::clamp((1 << 26) / system.size(), 20, system.has_preconditioner() ? 80 : 200);
  Eigen::GMRES<SystemMatrix, SystemPreconditioner> gmres;
  const SystemMatrix matrix(system);
  gmres.compute(matrix);
  gmres.set_restart(restart);
  gmres.setMaxIterations(most_iterations);
  gmres.setTolerance(tolerance * scale / first);  // Eigen's tolerance is relative to the first residual
  x = gmres.solveWithGuess(right_hand_side, x);
  const KrylovResult result{static_cast<int>(gmres.iterations()), gmres.error() * first / scale, scale};
  if (gmres.info() == Eigen::Success) return result;
  std::ostringstream message;
  message << "the multipole method's iteration stopped at a relative residual of " << result.residual << " after "
          << result.iterations << " steps, short of " << tolerance;
  throw Failure(message.str());
}

}  // namespace lichtenberg::laplace::multipole
