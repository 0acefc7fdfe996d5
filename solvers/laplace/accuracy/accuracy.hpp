#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Methods that support an accuracy request. (The relaxation is excluded: its staircase boundaries cause errors of some
/// percent on any affordable grid.)
enum class Method { cut_cell, multipole };

struct AccuracyRequest {
  double accuracy = 1e-3;        ///< Largest permitted error, as defined in ../measure.hpp; finest_accuracy to 0.1
  double reserve = 1;            ///< User's accuracy over this one; messages state the user's
  std::optional<Method> method;  ///< Required method; empty: the cheapest possible
  int most_cells = 32768;        ///< Upper bound of the cells along the longer side of the box
  double least_gap = INFINITY;   ///< Gap (m) between bodies of different potential down to which the choice must hold
  CutCellOptions cut_cell;       ///< Links, linear solver and device; cells and tolerance are chosen
};

constexpr double finest_accuracy = 1e-12;

/// Method with its parameters and error estimate.
struct Choice {
  Method method = Method::cut_cell;
  int cells = 0;         ///< Cells of the grid along the longer side; multipole method: of `field()` only
  double tolerance = 0;  ///< Tolerance of the solver
  double estimate = 0;   ///< Estimated error
};

/// Predicts the choice from geometry alone, without a solve. The method is final; cells and estimate are empirical
/// predictions. Throws InputError if the accuracy is out of range or far from attainable, or if the requested method
/// does not support the problem.
Choice predict_choice(const LaplaceProblem& problem, const AccuracyRequest& request);

/// Returns an upper estimate of the error for the choice's method, cells and tolerance. It uses coarser solutions on
/// five grids of S/4 to S/2 cells, with S the choice's cells, or the multipole method's own estimate. Throws the
/// exceptions of the solver.
double estimated_error(const LaplaceProblem& problem, const Choice& choice, const CutCellOptions& cut_cell);

struct AccurateSolution {
  Choice choice;
  std::unique_ptr<LaplaceSolver> solver;  ///< Solver that holds the solution
  LaplaceSolution solution;
};

/// Solves with error estimates, and with as many cells or digits as needed. Throws InputError if the accuracy cannot be
/// met; the message states the possible accuracy. Throws the exceptions of predict_choice and of the solver.
AccurateSolution solve_to_accuracy(const LaplaceProblem& problem, const AccuracyRequest& request);

}  // namespace lichtenberg::laplace
