#pragma once

// Initial guesses from stored solutions, as ../history.hpp; the operator is applied everywhere.

#include "solvers/laplace/cutcell/closest_shares.hpp"
#include "solvers/laplace/cutcell/device/operator.hpp"
#include "solvers/parallel/unroll.hpp"

namespace lichtenberg::laplace::device {

/// Values of the basis vectors of an initial guess at one place.
struct BasisValues {
  double of[history_length] = {};
  // Constant bounds keep the arrays in registers.
  LICHTENBERG_HOST_DEVICE friend BasisValues operator+(BasisValues a, const BasisValues& b) {
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p) a.of[p] += b.of[p];
    return a;
  }
  LICHTENBERG_HOST_DEVICE friend BasisValues operator-(BasisValues a, const BasisValues& b) {
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p) a.of[p] -= b.of[p];
    return a;
  }
  LICHTENBERG_HOST_DEVICE friend BasisValues operator*(double factor, BasisValues a) {
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p) a.of[p] *= factor;
    return a;
  }
};

/// Basis of an initial guess (device pointers): the newest solution, and the differences of successive ones, on the
/// unknowns of the present geometry. A newly uncovered cell has its conductor's last potential. A floating group
/// (bodies with one unknown potential) has the mean of its bodies, other groups 0. Values of cells are computed where
/// they are needed. `vector`, `image`: the groups' parts of the vectors and of their products with the operator A.
struct BasisView {
  /// Number of stored solutions and of vectors.
  int size;
  /// Stored solutions, the newest first.
  SolutionView solution[history_length];
  double *vector[history_length], *image[history_length];
  /// Products of the vectors, and the coefficients of the guess.
  GuessProducts* products;
  Shares* shares;

  /// Returns the values at a cell's memory index (slot).
  LICHTENBERG_HOST_DEVICE BasisValues at(const GridView& grid, int slot) const {
    const bool is_unknown = grid.cells.inverse_diagonal[slot] > 0;
    double stored[history_length] = {};
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p)  // at once with the diagonal
      if (p < size) stored[p] = solution[p].cell[slot];
    BasisValues values;
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p)
      if (is_unknown && p < size) values.of[p] = p == 0 ? stored[0] : stored[p - 1] - stored[p];
    return values;
  }
  /// Returns the value of vector p at a body.
  LICHTENBERG_HOST_DEVICE double at_body(int p, int body) const {
    return p == 0 ? solution[0].body[body] : solution[p - 1].body[body] - solution[p].body[body];
  }
  /// Returns the values at group g (bodies with one potential).
  LICHTENBERG_HOST_DEVICE BasisValues at_group(double* const* by_group, int g) const {
    BasisValues values;
    LICHTENBERG_UNROLL(3)
    for (int p = 0; p < history_length; ++p)
      if (p < size) values.of[p] = by_group[p][g];
    return values;
  }
};

/// Computes the groups' parts of the basis vectors and of their products with the operator A. A group is a set of
/// bodies with one potential.
template <class Executor>
void make_basis_of_groups(const Executor& run, ProblemView problem, GridView grid, BasisView basis) {
  for (int p = 0; p < basis.size; ++p) {
    average_bodies(run, problem, grid, basis.vector[p],
                   [=] LICHTENBERG_HOST_DEVICE(int body) { return basis.at_body(p, body); });
    apply_to_groups(
        run, problem, grid,
        [=] LICHTENBERG_HOST_DEVICE(int slot) {
          const double newest = basis.solution[p == 0 ? 0 : p - 1].cell[slot];
          return p == 0 ? newest : newest - basis.solution[p].cell[slot];
        },
        basis.vector[p], basis.image[p]);
    add_couplings(run, problem, basis.vector[p], basis.image[p]);
  }
}

/// Returns the products of the basis vectors' values at one place with each other's `image` and with b.
LICHTENBERG_HOST_DEVICE inline GuessProducts guess_products(const BasisValues& vector, const BasisValues& image,
                                                            double b) {
  GuessProducts products;
  for (int p = 0; p < history_length; ++p) {
    products.rhs[p] = vector.of[p] * b;
    for (int q = 0; q <= p; ++q) products.gram[p][q] = image.of[p] * vector.of[q];
  }
  return products;
}

/// Computes the coefficients of the basis vectors by Galerkin projection (closest_shares). b: right-hand side. One pass
/// over the cells computes the vectors, their products with the operator A and the sums.
template <class Executor>
void compute_shares(const Executor& run, ProblemView problem, GridView grid, BasisView basis, const double* b) {
  const int cells = static_cast<int>(grid.layout.size());
  make_basis_of_groups(run, problem, grid, basis);
  sum_of_entries(
      run, problem, grid,
      [=] LICHTENBERG_HOST_DEVICE(const Place& at) {
        if (!at.is_cell) return GuessProducts{};
        const BasisValues own = basis.at(grid, at.slot);
        const BasisValues image = field_row(
            problem, grid, at, own, [&](int slot) { return basis.at(grid, slot); },
            [&](int g) { return basis.at_group(basis.vector, g); });
        return guess_products(own, image, b[at.slot]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int g) {
        return guess_products(basis.at_group(basis.vector, g), basis.at_group(basis.image, g), b[cells + g]);
      },
      [=] LICHTENBERG_HOST_DEVICE(const GuessProducts& products) { *basis.products = products; });
  // In a kernel of its own, because it needs many registers.
  run.template for_each<32>(
      1, [=] LICHTENBERG_HOST_DEVICE(int) { *basis.shares = closest_shares(*basis.products, basis.size); });
}

/// Computes the linear combination x of the basis vectors with their coefficients.
template <class Executor>
void combine(const Executor& run, ProblemView problem, GridView grid, BasisView basis, double* x) {
  const int cells = static_cast<int>(grid.layout.size());
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const BasisValues values = k < cells ? basis.at(grid, k) : basis.at_group(basis.vector, k - cells);
    double sum = 0;
    for (int p = 0; p < history_length; ++p)
      if (p < basis.size) sum += basis.shares->of[p] * values.of[p];
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
