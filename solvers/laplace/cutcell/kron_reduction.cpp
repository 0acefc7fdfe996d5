#include "solvers/laplace/cutcell/kron_reduction.hpp"

#include "solvers/laplace/cutcell/slabs.hpp"

namespace lichtenberg::laplace {

void KronReduction::build(const EliminatedCells& cells, const Layout& layout, std::vector<float>& group_diagonal) {
  cells_ = cells;
  colour_size_ = layout.colour_size();
  own_ = layout.own;
  row_start_.assign(layout.ny + 1, 0);
  share_.clear();
  for (std::size_t k = 0; k < cells_.cells.size(); ++k) {
    const EliminatedCells::Cell& cell = cells_.cells[k];
    ++row_start_[cell.row + 1];
    for (int m = cells_.start[k]; m < cells_.start[k + 1]; ++m)
      share_.push_back(cells_.links[m].conductance / cell.diagonal);
  }
  for (int j = 0; j < layout.ny; ++j) row_start_[j + 1] += row_start_[j];
  add_sums(layout, std::ssize(group_diagonal), group_diagonal.data(), [this](float* sum) {
    for (int k = row_start_[own_.begin]; k < row_start_[own_.end]; ++k)
      for (int m = cells_.start[k]; m < cells_.start[k + 1]; ++m) {
        const auto& [body, group, conductance] = cells_.links[m];
        sum[group] += static_cast<float>(EliminatedCells::schur_diagonal(conductance, cells_.cells[k].diagonal));
      }
  });
  f_.assign(cells_.cells.size(), 0.0);
  flux_.assign(cells_.cells.size(), 0.0);
}

void KronReduction::start(const std::vector<float>& f) {
  for (std::size_t k = 0; k < cells_.cells.size(); ++k) flux_[k] = f_[k] = f[cells_.cells[k].slot];
}

void KronReduction::set_relaxed(const std::vector<float>& v, const std::vector<float>& phi) {
  for (std::size_t k = 0; k < cells_.cells.size(); ++k) {
    flux_[k] = cells_.cells[k].diagonal * v[cells_.cells[k].slot];
    for (int m = cells_.start[k]; m < cells_.start[k + 1]; ++m)
      flux_[k] -= cells_.links[m].conductance * phi[cells_.links[m].group];
  }
}

void KronReduction::add_fluxes(float* sum) const {
  for (int k = row_start_[own_.begin]; k < row_start_[own_.end]; ++k)
    for (int m = cells_.start[k]; m < cells_.start[k + 1]; ++m)
      sum[cells_.links[m].group] += static_cast<float>(share_[m] * flux_[k]);
}

void KronReduction::substitute(const std::vector<float>& phi, const double* r, double* row_product,
                               std::vector<float>& v) const {
  for (std::size_t k = 0; k < cells_.cells.size(); ++k) {
    const EliminatedCells::Cell& cell = cells_.cells[k];
    double flux = flux_[k];
    for (int m = cells_.start[k]; m < cells_.start[k + 1]; ++m)
      flux += cells_.links[m].conductance * phi[cells_.links[m].group];
    const auto value = static_cast<float>(flux / cell.diagonal);
    if (r && own_.contains(cell.row)) row_product[cell.row] += r[cell.slot] * (value - v[cell.slot]);
    v[cell.slot] = value;
  }
}

}  // namespace lichtenberg::laplace
