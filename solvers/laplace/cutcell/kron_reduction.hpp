#pragma once

#include <vector>

#include "solvers/laplace/cutcell/eliminated_cells.hpp"
#include "solvers/laplace/cutcell/layout.hpp"

namespace lichtenberg::laplace {

/// Kron reduction (Schur complement) of near-surface cells Q in the relaxation of a grid's groups G. A near-surface
/// cell is a fluid cell with a very large link conductance. The groups are relaxed with A_GG - A_GQ D^-1 A_QG instead
/// of A_GG; D is the diagonal of the cells. Before the coarse-grid correction the groups receive their share of the
/// cells' residuals. After it, back substitution sets the cells. The two steps are transposes of each other, so that
/// the cycle remains symmetric. In sweeps over cells, a near-surface cell is an unknown like any other. A group is a
/// set of bodies with one potential.
class KronReduction {
 public:
  /// Copies the list of eliminated cells, and computes for each of their links the share of the cell's flux that goes
  /// to the link's group. On entry `group_diagonal` [groups] contains the sums of conductances without links to these
  /// cells. On return it is the diagonal of the Schur complement. A group is a set of bodies with one potential. In a
  /// slab, sums over groups are those of the cells in own rows.
  void build(const EliminatedCells& cells, const Layout& layout, std::vector<float>& group_diagonal);

  /// Starts a V-cycle from zero potentials: copies the right-hand side of the eliminated cells, which is then also
  /// their flux. `f`: right-hand side of all cells by slot (memory index).
  void start(const std::vector<float>& f);
  /// Computes the flux into the eliminated cells (with a large conductance to a conductor) of a colour in row j
  /// (right-hand side plus neighbours). To be called after the relaxation of these cells. `flux_from_neighbours` maps a
  /// cell to the flux from the four cells around it.
  template <class Flux>
  void update(int colour, int j, const Flux& flux_from_neighbours) {
    for (int k = row_start_[j]; k < row_start_[j + 1]; ++k)
      if (is_red(cells_.cells[k]) == (colour == 0)) flux_[k] = f_[k] + flux_from_neighbours(cells_.cells[k]);
  }
  /// Sets the stored fluxes of the eliminated cells, which have a large conductance to a conductor. Relaxation with the
  /// group potentials phi would then give the cell potentials v. A group is a set of bodies with one potential.
  void set_relaxed(const std::vector<float>& v, const std::vector<float>& phi);
  /// Computes the residuals of red eliminated cells (with a large conductance to a conductor) in row j after a sweep
  /// over both colours. They are differences of fluxes, which avoids the cancellation in a residual from f and v.
  /// `residual`: by slot (memory index).
  template <class Flux>
  void set_red_residuals(int j, const Flux& flux_from_neighbours, std::vector<float>& residual) const {
    for (int k = row_start_[j]; k < row_start_[j + 1]; ++k)
      if (const EliminatedCells::Cell& cell = cells_.cells[k]; is_red(cell))
        residual[cell.slot] = static_cast<float>(f_[k] + flux_from_neighbours(cell) - flux_[k]);
  }
  /// Adds the flux that each group (bodies with one potential) receives from the eliminated cells (with a large
  /// conductance to a conductor) to `sum` [groups].
  void add_fluxes(float* sum) const;
  /// Computes the potentials of the eliminated cells (with a large conductance to a conductor) in v from the group
  /// potentials phi (back substitution). Unless r is null, updates `row_product`, the scalar products of r and v by
  /// row. A group is a set of bodies with one potential.
  void substitute(const std::vector<float>& phi, const double* r, double* row_product, std::vector<float>& v) const;

 private:
  bool is_red(const EliminatedCells::Cell& cell) const { return cell.slot < colour_size_; }

  EliminatedCells cells_;
  std::ptrdiff_t colour_size_ = 0;
  Rows own_;
  // [rows + 1] a row's first cell.
  std::vector<int> row_start_;
  // By link: share of the cell's flux that goes to the link's group.
  std::vector<double> share_;
  // By cell: right-hand side, and with it the flux from neighbouring cells at the last relaxation.
  std::vector<double> f_, flux_;
};

}  // namespace lichtenberg::laplace
