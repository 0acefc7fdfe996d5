#pragma once

#include <memory>
#include <utility>

#include "solvers/laplace/problem.hpp"

namespace lichtenberg {

/// Counters of a solver that a test has passed to another object.
struct SolverLog {
  int solves = 0;
  int forgets = 0;
};

/// Field solver with a simple closed form. Each disk is a line charge at its centre. The potential of disk i is
///   phi_i = -1/(2 pi eps) * (q_i ln(R_i / L) + sum_j q_j ln(d_ij / L)),   L = width of the box,
/// as for a circular ground of radius L at a large distance. Groups distribute their charge to equal potentials. Forces
/// are the exact derivatives of the energy. Bodies must be disks; the box has no other effect.
///
/// The solution depends slightly on earlier solves, as that of an iterative solver does: the k-th solve after forget()
/// is multiplied by 1 + 1e-9 k.
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
