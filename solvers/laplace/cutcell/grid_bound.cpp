// What a grid of the cycle does with bound cells (bound_cells.hpp). Conductors are relaxed as if these cells followed
// them: S = A_GG - A_GQ D^-1 A_QG in place of A_GG, G the groups, Q the bound cells, D their diagonals. On the way down
// a group takes its share of a bound cell's residual, and the cells, relaxed next, need not be told; on the way up they
// are as they should be, and follow: each is the other's transpose, and the cycle stays symmetric. Relaxed in between,
// a bound cell stays an unknown like any other.

#include "solvers/laplace/cutcell/grid.hpp"

namespace lichtenberg::laplace {

/// Adds to the groups' diagonals what bound cells leave of their links.
void Grid::build_bound(const Level& level, std::vector<float>& group_diagonal) {
  bound_ = level.bound;
  bound_row_.assign(layout.ny + 1, 0);
  bound_share_.clear();
  for (std::size_t k = 0; k < bound_.cells.size(); ++k) {
    const BoundCells::Cell& cell = bound_.cells[k];
    ++bound_row_[cell.row + 1];
    for (int m = bound_.start[k]; m < bound_.start[k + 1]; ++m) {
      const auto& [body, group, conductance] = bound_.links[m];
      group_diagonal[group] += static_cast<float>(BoundCells::kept(conductance, cell.diagonal));
      bound_share_.push_back(conductance / cell.diagonal);
    }
  }
  for (int j = 0; j < layout.ny; ++j) bound_row_[j + 1] += bound_row_[j];
  bound_f_.assign(bound_.cells.size(), 0.0);
  bound_flux_.assign(bound_.cells.size(), 0.0);
}

void Grid::start_bound() {
  for (std::size_t k = 0; k < bound_.cells.size(); ++k) bound_flux_[k] = bound_f_[k] = f[bound_.cells[k].slot];
}

/// What the four cells around one bring it.
float Grid::flux_from_cells(const BoundCells::Cell& cell) const {
  const int colour = cell.slot < layout.colour_size() ? 0 : 1;
  const std::ptrdiff_t number = cell.slot - layout.row(colour, cell.row);
  const std::ptrdiff_t west = layout.row(1 - colour, cell.row) + Layout::parity(colour, cell.row) - 1 + number;
  const std::ptrdiff_t south = layout.row(1 - colour, cell.row - 1) + number;
  const std::ptrdiff_t north = layout.row(1 - colour, cell.row + 1) + number;
  if (east_.empty()) return v[west] + v[west + 1] + v[south] + v[north];
  return east_[west] * v[west] + east_[cell.slot] * v[west + 1] + north_[south] * v[south] +
         north_[cell.slot] * v[north];
}

/// To be called whenever a row's cells of a colour have been relaxed.
void Grid::note_bound(int colour, int j) {
  for (int k = bound_row_[j]; k < bound_row_[j + 1]; ++k)
    if ((bound_.cells[k].slot < layout.colour_size()) == (colour == 0))
      bound_flux_[k] = bound_f_[k] + flux_from_cells(bound_.cells[k]);
}

/// As if v were what the bound cells had been relaxed to.
void Grid::take_bound_as_relaxed() {
  for (std::size_t k = 0; k < bound_.cells.size(); ++k) {
    bound_flux_[k] = bound_.cells[k].diagonal * v[bound_.cells[k].slot];
    for (int m = bound_.start[k]; m < bound_.start[k + 1]; ++m)
      bound_flux_[k] -= bound_.links[m].conductance * phi[bound_.links[m].group];
  }
}

/// The red ones' residuals, where a sweep over both colours has changed what reaches them: without the difference of
/// large numbers that the row's own residual is.
void Grid::set_bound_residuals(int j) {
  for (int k = bound_row_[j]; k < bound_row_[j + 1]; ++k)
    if (const BoundCells::Cell& cell = bound_.cells[k]; cell.slot < layout.colour_size())
      residual_[cell.slot] = static_cast<float>(bound_f_[k] + flux_from_cells(cell) - bound_flux_[k]);
}

void Grid::add_bound_fluxes(std::vector<float>& sum) const {
  for (std::size_t k = 0; k < bound_.cells.size(); ++k)
    for (int m = bound_.start[k]; m < bound_.start[k + 1]; ++m)
      sum[bound_.links[m].group] += static_cast<float>(bound_share_[m] * bound_flux_[k]);
}

/// Bound cells become what the groups have become. With r, row_product changes with them.
void Grid::follow_groups(const double* r, double* row_product) {
  for (std::size_t k = 0; k < bound_.cells.size(); ++k) {
    const BoundCells::Cell& cell = bound_.cells[k];
    double flux = bound_flux_[k];
    for (int m = bound_.start[k]; m < bound_.start[k + 1]; ++m)
      flux += bound_.links[m].conductance * phi[bound_.links[m].group];
    const auto value = static_cast<float>(flux / cell.diagonal);
    if (r) row_product[cell.row] += r[cell.slot] * (value - v[cell.slot]);
    v[cell.slot] = value;
  }
}

}  // namespace lichtenberg::laplace
