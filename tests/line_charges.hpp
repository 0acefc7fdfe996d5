#pragma once

#include <memory>
#include <utility>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg {

/// What a test wants to know about a solver that it has given away.
struct SolverLog {
  int solves = 0;
  int forgets = 0;
};

/// A field solver small enough to check by hand: each disk is a line charge at its centre, and the potential of disk i
/// is
///   phi_i = -1/(2 pi eps) * (q_i ln(R_i / L) + sum_j q_j ln(d_ij / L)),   L = width of the box,
/// as if the ground were a circle of radius L far away. Groups share their charge so that their potentials are equal.
/// Forces are the exact derivative of the energy. Bodies must be disks; the box plays no other part.
///
/// Like an iterative solver it ends near its solution, where exactly depends on the solves before: the k-th one since
/// it last forgot is off by a factor 1 + 1e-9 k.
class LineCharges : public laplace::LaplaceSolver {
 public:
  explicit LineCharges(std::shared_ptr<SolverLog> log = std::make_shared<SolverLog>()) : log_(std::move(log)) {}

  laplace::LaplaceSolution solve(const laplace::LaplaceProblem& problem) override;
  laplace::Field field() const override { return {}; }
  void forget() override;

 private:
  std::shared_ptr<SolverLog> log_;
  int solves_since_forget_ = 0;
};

}  // namespace lichtenberg
