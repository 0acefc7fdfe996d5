#pragma once

#include <vector>

#include "solvers/laplace/cutcell/eliminated_cells.hpp"
#include "solvers/laplace/cutcell/layout.hpp"

namespace lichtenberg::laplace {

/// Kron reduction of near-surface cells Q in the relaxation of a grid's groups G. The groups are relaxed with the Schur
/// complement A_GG - A_GQ D^-1 A_QG instead of A_GG; D is the diagonal of the cells. Before the coarse-grid
/// correction the groups receive their share of the cells' residuals; after it, back substitution sets the cells. The
/// two steps are transposes of each other, so that the cycle remains symmetric. In the sweeps over cells, a
/// near-surface cell is an unknown like any other.
class KronReduction {
 public:
  /// `group_diagonal` [groups]: sums of conductances without links to these cells; the diagonal of the Schur complement
  /// is added.
  void build(const EliminatedCells& cells, const Layout& layout, std::vector<float>& group_diagonal);

  /// Starts a cycle with right-hand side f and potentials zero.
  void start(const std::vector<float>& f);
  /// Updates the flux into the cells of a colour in row j after their relaxation. `flux_from_neighbours` maps a cell to
  /// the flux from the four cells around it.
  template <class Flux>
  void update(int colour, int j, const Flux& flux_from_neighbours) {
    for (int k = row_start_[j]; k < row_start_[j + 1]; ++k)
      if (is_red(cells_.cells[k]) == (colour == 0)) flux_[k] = f_[k] + flux_from_neighbours(cells_.cells[k]);
  }
  /// Sets the fluxes for which relaxation with the groups' potentials phi would give v.
  void set_relaxed(const std::vector<float>& v, const std::vector<float>& phi);
  /// Sets the residuals of red cells in row j after a sweep over both colours, without the cancellation in a residual
  /// from f and v.
  template <class Flux>
  void set_red_residuals(int j, const Flux& flux_from_neighbours, std::vector<float>& residual) const {
    for (int k = row_start_[j]; k < row_start_[j + 1]; ++k)
      if (const EliminatedCells::Cell& cell = cells_.cells[k]; is_red(cell))
        residual[cell.slot] = static_cast<float>(f_[k] + flux_from_neighbours(cell) - flux_[k]);
  }
  /// Adds the flux from the cells to each group to `sum` [groups].
  void add_fluxes(std::vector<float>& sum) const;
  /// Back substitution: sets the cells in v from the groups' potentials. Updates row_product, the products r'v by row,
  /// unless r is null.
  void substitute(const std::vector<float>& phi, const double* r, double* row_product, std::vector<float>& v) const;

 private:
  bool is_red(const EliminatedCells::Cell& cell) const { return cell.slot < colour_size_; }

  EliminatedCells cells_;
  std::ptrdiff_t colour_size_ = 0;
  // [rows + 1] a row's first cell.
  std::vector<int> row_start_;
  // By link: share of the cell's flux that goes to the link's group.
  std::vector<double> share_;
  // By cell: right-hand side, and with it the flux from neighbouring cells at the last relaxation.
  std::vector<double> f_, flux_;
};

}  // namespace lichtenberg::laplace
