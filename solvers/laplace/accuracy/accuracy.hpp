#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace {

/// Those that can be asked for an accuracy. (The relaxation's error is its staircase, some percent on any grid that it
/// can afford.)
enum class Method { cut_cell, multipole };

struct AccuracyRequest {
  double accuracy = 1e-3;        ///< largest error allowed, as ../measure.hpp defines it; finest_accuracy to 0.1
  double reserve = 1;            ///< user's accuracy over this one; messages name the user's
  std::optional<Method> method;  ///< this one; empty: the cheapest that can
  int most_cells = 32768;        ///< along the longer side of the box
  double least_gap = INFINITY;   ///< m: the choice shall hold until bodies of different potential are as close as this
  CutCellOptions cut_cell;       ///< its links, linear solver and device; cells and tolerance are chosen
};

constexpr double finest_accuracy = 1e-12;

/// How to solve a problem, and how good that is.
struct Choice {
  Method method = Method::cut_cell;
  int cells = 0;         ///< of the grid, along the longer side; multipole: of `field()` only
  double tolerance = 0;  ///< of the solver
  double estimate = 0;   ///< of the error that is left
};

/// The choice from geometry alone, before anything is solved: the method is final, cells and estimate are what
/// experience makes likely (README.md). Throws InputError where the method asked for cannot solve the problem.
Choice foresee(const LaplaceProblem& problem, const AccuracyRequest& request);

/// Upper estimate of the error of what the choice's method, cells and tolerance give: by coarser solutions on five
/// grids of S/4 to S/2 cells, or by what the multipole method's says of itself.
double estimated_error(const LaplaceProblem& problem, const Choice& choice, const CutCellOptions& cut_cell);

struct AccurateSolution {
  Choice choice;
  std::unique_ptr<LaplaceSolver> solver;  ///< that of the solution
  LaplaceSolution solution;
};

/// Solves with estimates on the way, with as many cells, or digits, as it takes. Throws InputError if the accuracy
/// cannot be met, with what can be.
AccurateSolution solve_to_accuracy(const LaplaceProblem& problem, const AccuracyRequest& request);

}  // namespace lichtenberg::laplace
