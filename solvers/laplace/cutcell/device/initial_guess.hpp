#pragma once

// Initial guesses from stored solutions, as ../history.hpp; the operator is applied everywhere.

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/device/operator.hpp"

namespace lichtenberg::laplace::device {

/// Basis vectors of an initial guess, and their products with the operator A (`image`); device pointers.
struct BasisView {
  int size;
  double *vector[history_length], *image[history_length];
};

/// Computes the coefficients `shares` of the basis vectors by Galerkin projection (closest_shares). b: right-hand side;
/// n: number of entries of each vector.
template <class Executor>
void compute_shares(const Executor& run, long n, BasisView basis, const double* b, Shares* shares) {
  const int m = basis.size;
  run.sum(
      n,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        GuessProducts products;
        double vector[history_length];
        for (int p = 0; p < history_length; ++p) {  // constant bounds keep the arrays in registers
          if (p >= m) continue;
          vector[p] = basis.vector[p][k];
          const double image = basis.image[p][k];
          products.rhs[p] = vector[p] * b[k];
          for (int q = 0; q <= p; ++q) products.gram[p][q] = image * vector[q];
        }
        return products;
      },
      [=] LICHTENBERG_HOST_DEVICE(const GuessProducts& products) { *shares = closest_shares(products, m); });
}

/// Computes the linear combination x of the basis vectors with the coefficients `shares`.
template <class Executor>
void combine(const Executor& run, long n, BasisView basis, const Shares* shares, double* x) {
  run.for_each(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
    double sum = 0;
    for (int p = 0; p < history_length; ++p)
      if (p < basis.size) sum += shares->of[p] * basis.vector[p][k];
    x[k] = sum;
  });
}

/// Smooths the initial guess x by `sweeps` sweeps over the groups and the cells next to conductors, where its largest
/// errors are (CutCellOperator::relax_edges). `next`: scratch memory, one value per group. A group is a set of bodies
/// with one potential.
template <class Executor>
void relax_edges(const Executor& run, ProblemView problem, GridView grid, SolveVectors v, double* next, int sweeps) {
  const double* b = v.b;
  double* x = v.x;
  const int cells = static_cast<int>(grid.layout.size()), colour_size = static_cast<int>(grid.layout.colour_size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    solve_group_potentials(run, problem, grid, b, x, next);
    for (int colour = 0; colour < 2; ++colour)
      for_each_item(run, grid, Items::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
        const int slot = grid.boundary.slot[k];
        if ((slot >= colour_size) != (colour == 1)) return;
        const Neighbours n = neighbours(grid.layout, slot);
        double sum = b[slot] + x[n.west] + x[n.east] + x[n.south] + x[n.north];
        for (int side = 0; side < 4; ++side) {
          const int link = grid.boundary_link_of(k, side);
          if (link >= 0) sum += grid.links.conductance[link] * x[cells + grid.links.group[link]];
        }
        x[slot] = sum / grid.boundary.diagonal[k];
      });
  }
  solve_group_potentials(run, problem, grid, b, x, next);
}

}  // namespace lichtenberg::laplace::device
