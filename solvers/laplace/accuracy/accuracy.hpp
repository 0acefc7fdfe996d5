#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Field methods among which an accuracy request chooses. The relaxation method is excluded, because its staircase
/// boundaries cause errors of some percent on any affordable grid.
enum class Method { cut_cell, multipole };

/// Request for a field solution of given accuracy, with restrictions of the choice of method and grid.
struct AccuracyRequest {
  double accuracy = 1e-3;        ///< Largest permitted error (largest_error of ../measure.hpp); finest_accuracy to 0.1
  double reserve = 1;            ///< Ratio of the accuracy that the user requested to `accuracy`, for error messages
  std::optional<Method> method;  ///< Required method; empty: the cheapest possible
  int most_cells = 32768;        ///< Upper bound of the cells along the longer side of the box
  double least_gap = INFINITY;   ///< Gap (m) between bodies of different potential down to which the choice must hold
  CutCellOptions cut_cell;       ///< Options of the cut-cell method, of which cells and tolerance are chosen
};

/// Smallest accuracy that can be requested.
constexpr double finest_accuracy = 1e-12;

/// Chosen field method with its parameters and error estimate.
struct Choice {
  Method method = Method::cut_cell;
  int cells = 0;         ///< Cells of the grid along the longer side; multipole method: of `field()` only
  double tolerance = 0;  ///< Tolerance of the solver
  double estimate = 0;   ///< Estimated error
};

/// Predicts the method, grid and tolerance for a requested accuracy from the geometry, without a solve. The method is
/// final; for the cut-cell method, number of cells and error estimate are empirical predictions. Throws InputError if
/// the accuracy is out of range or far from attainable, or if the requested method does not support the problem. Also
/// throws InputError if no permitted grid of square cells fits the box.
Choice predict_choice(const LaplaceProblem& problem, const AccuracyRequest& request);

/// Computes an upper estimate of the relative error of a solution with the choice's method, cells and tolerance. For
/// the cut-cell method it solves on the choice's grid and on five coarser grids with 1/4 to 1/2 of its cells
/// (Richardson extrapolation). For the multipole method it solves once, and the result is at least that method's own
/// estimate. Throws the exceptions of the solver.
double estimated_error(const LaplaceProblem& problem, const Choice& choice, const CutCellOptions& cut_cell);

/// Solution of requested accuracy, with the method that was chosen.
struct AccurateSolution {
  Choice choice;
  std::unique_ptr<LaplaceSolver> solver;  ///< Solver after this solution, for its field()
  LaplaceSolution solution;
};

/// Solves a field problem to a requested accuracy: refines the grid or tightens the tolerance until the estimated error
/// is small enough. Throws InputError if the accuracy cannot be met; the message estimates the possible accuracy.
/// Throws the exceptions of predict_choice and of the solver.
AccurateSolution solve_to_accuracy(const LaplaceProblem& problem, const AccuracyRequest& request);

}  // namespace lichtenberg::laplace
