#include "solvers/laplace/cutcell/multigrid.hpp"

#include <algorithm>

#include "solvers/laplace/cutcell/coarse.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"

namespace lichtenberg::laplace {

namespace {

/// Groups coupled directly by pair links, as a sparse matrix over groups.
struct GroupCoupling {
  std::vector<int> start, other;
  std::vector<float> conductance;
};

GroupCoupling couple_groups(const LaplaceProblem& problem, const Level& level) {
  const auto group = [&](int body) { return problem.bodies[body].group; };
  GroupCoupling coupling;
  coupling.start.assign(problem.groups.size() + 1, 0);
  for (const PairLink& pair : level.pairs) {
    ++coupling.start[group(pair.body_a) + 1];
    ++coupling.start[group(pair.body_b) + 1];
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g) coupling.start[g + 1] += coupling.start[g];
  coupling.other.resize(coupling.start.back());
  coupling.conductance.resize(coupling.start.back());
  std::vector<int> next(coupling.start.begin(), coupling.start.end() - 1);
  const auto put = [&](int g, int h, double c) {
    coupling.other[next[g]] = h;
    coupling.conductance[next[g]++] = static_cast<float>(c);
  };
  for (const PairLink& pair : level.pairs) {
    put(group(pair.body_a), group(pair.body_b), pair.conductance);
    put(group(pair.body_b), group(pair.body_a), pair.conductance);
  }
  return coupling;
}

/// v = (f + sum of the four neighbours) / diagonal along one row of one colour. `west` points at the neighbour on the
/// left of the first cell; the one on its right follows it.
inline void relax_row(int n, float* __restrict v, const float* __restrict f, const float* __restrict inverse_diagonal,
                      const float* __restrict west, const float* __restrict south, const float* __restrict north) {
  for (int k = 0; k < n; ++k) v[k] = (f[k] + west[k] + west[k + 1] + south[k] + north[k]) * inverse_diagonal[k];
}

inline void relax_row_from_zero(int n, float* __restrict v, const float* __restrict f,
                                const float* __restrict inverse_diagonal) {
  for (int k = 0; k < n; ++k) v[k] = f[k] * inverse_diagonal[k];
}

/// After a sweep from zero over red and then black, a red cell's residual is what its black neighbours have brought.
inline void residual_row(int n, float* __restrict r, const float* __restrict inverse_diagonal,
                         const float* __restrict west, const float* __restrict south, const float* __restrict north) {
  for (int k = 0; k < n; ++k) r[k] = inverse_diagonal[k] > 0 ? west[k] + west[k + 1] + south[k] + north[k] : 0.0f;
}

}  // namespace

struct Multigrid::Grid {
  Layout layout;
  std::vector<float> v, f, residual, inverse_diagonal;  // by slot; residual: red cells only
  // Couplings of fluid cells with floating groups.
  std::vector<std::int32_t> link_cell, link_group;
  std::vector<float> link_conductance;
  // Covered cells of floating groups.
  std::vector<std::int32_t> covered_cell, covered_group;
  std::vector<float> phi, charge, group_inverse_diagonal, accumulator;  // by group
  GroupCoupling coupling;
  std::array<float, 4> mirror{};  // +1 at an insulating side, -1 at an electrode
  std::vector<float> row_a, row_b, row_c;

  explicit Grid(const Layout& at)
      : layout(at),
        v(at.size()),
        f(at.size()),
        residual(at.colour_size()),
        inverse_diagonal(at.size()),
        row_a(at.nx + 2 * Layout::pad),
        row_b(at.nx + 2 * Layout::pad),
        row_c(at.nx + 2 * Layout::pad) {}

  void build(const LaplaceProblem& problem, const Level& level);
  void relax(int colour, int j);
  void sweep_from_zero();
  void relax_groups(bool forward);
  void add_group_potentials(const std::vector<float>& increment);
  void group_residual(std::vector<float>& r);
  void restrict_to(Grid& coarse);
  void coarse_row(int J, float* row) const;
  void prolongate_from(const Grid& coarse);
};

void Multigrid::Grid::build(const LaplaceProblem& problem, const Level& level) {
  const std::size_t groups = problem.groups.size();
  for (std::ptrdiff_t slot = 0; slot < layout.size(); ++slot)
    inverse_diagonal[slot] = level.diagonal[slot] > 0 ? static_cast<float>(1.0 / level.diagonal[slot]) : 0.0f;
  // The coarsest grid's solve sets unknowns only: cells that a grounded conductor covers now would keep what they had.
  std::fill(v.begin(), v.end(), 0.0f);
  link_cell.clear();
  link_group.clear();
  link_conductance.clear();
  covered_cell.clear();
  covered_group.clear();
  std::vector<double> group_diagonal(groups, 0.0);
  for (const Link& link : level.links) {
    const int g = problem.bodies[link.body].group;
    if (!problem.groups[g].floating) continue;
    group_diagonal[g] += link.conductance;
    link_cell.push_back(static_cast<std::int32_t>(link.cell));
    link_group.push_back(g);
    link_conductance.push_back(static_cast<float>(link.conductance));
  }
  for (const PairLink& pair : level.pairs) {
    group_diagonal[problem.bodies[pair.body_a].group] += pair.conductance;
    group_diagonal[problem.bodies[pair.body_b].group] += pair.conductance;
  }
  for (const SideLink& link : level.side_links)
    if (link.body >= 0) group_diagonal[problem.bodies[link.body].group] += link.conductance;
  for (const std::ptrdiff_t slot : level.covered) {
    const int g = problem.bodies[level.cover[slot]].group;
    if (!problem.groups[g].floating) continue;
    covered_cell.push_back(static_cast<std::int32_t>(slot));
    covered_group.push_back(g);
  }
  phi.assign(groups, 0.0f);
  charge.assign(groups, 0.0f);
  accumulator.assign(groups, 0.0f);
  group_inverse_diagonal.assign(groups, 0.0f);
  for (std::size_t g = 0; g < groups; ++g)
    if (problem.groups[g].floating && group_diagonal[g] > 0)
      group_inverse_diagonal[g] = static_cast<float>(1.0 / group_diagonal[g]);
  coupling = couple_groups(problem, level);
  for (int side = 0; side < 4; ++side) mirror[side] = problem.sides[side].kind == Side::Kind::electrode ? -1.0f : 1.0f;
}

void Multigrid::Grid::relax(int colour, int j) {
  const std::ptrdiff_t at = layout.row(colour, j), other = 1 - colour;
  relax_row(layout.row_length(colour, j), &v[at], &f[at], &inverse_diagonal[at],
            &v[layout.row(other, j) + Layout::parity(colour, j) - 1], &v[layout.row(other, j - 1)],
            &v[layout.row(other, j + 1)]);
}

/// Red, black, and the residual left in the red cells, each a row behind the other: one pass over memory.
void Multigrid::Grid::sweep_from_zero() {
  for (int j = 0; j < layout.ny + 2; ++j) {
    if (j < layout.ny) {
      const std::ptrdiff_t at = layout.row(0, j);
      relax_row_from_zero(layout.row_length(0, j), &v[at], &f[at], &inverse_diagonal[at]);
    }
    if (j >= 1 && j - 1 < layout.ny) relax(1, j - 1);
    if (j >= 2) {
      const int row = j - 2;
      const std::ptrdiff_t at = layout.row(0, row);
      residual_row(layout.row_length(0, row), &residual[at], &inverse_diagonal[at],
                   &v[layout.row(1, row) + Layout::parity(0, row) - 1], &v[layout.row(1, row - 1)],
                   &v[layout.row(1, row + 1)]);
    }
  }
}

/// Each group's potential from its charge, its cells and the groups it is coupled with directly (Gauss-Seidel, in
/// ascending or descending order).
void Multigrid::Grid::relax_groups(bool forward) {
  const int groups = static_cast<int>(phi.size());
  for (int k = 0; k < groups; ++k) {
    const int g = forward ? k : groups - 1 - k;
    float flux = charge[g] + accumulator[g];
    for (int m = coupling.start[g]; m < coupling.start[g + 1]; ++m)
      flux += coupling.conductance[m] * phi[coupling.other[m]];
    phi[g] = flux * group_inverse_diagonal[g];
  }
}

void Multigrid::Grid::add_group_potentials(const std::vector<float>& increment) {
  for (std::size_t m = 0; m < link_cell.size(); ++m) f[link_cell[m]] += link_conductance[m] * increment[link_group[m]];
}

void Multigrid::Grid::group_residual(std::vector<float>& r) {
  std::fill(accumulator.begin(), accumulator.end(), 0.0f);
  for (std::size_t m = 0; m < link_cell.size(); ++m)
    accumulator[link_group[m]] += link_conductance[m] * v[link_cell[m]];
  for (std::size_t g = 0; g < phi.size(); ++g) {
    float flux = charge[g] + accumulator[g];
    for (int m = coupling.start[g]; m < coupling.start[g + 1]; ++m)
      flux += coupling.conductance[m] * phi[coupling.other[m]];
    r[g] = group_inverse_diagonal[g] > 0 ? flux - phi[g] / group_inverse_diagonal[g] : 0.0f;
  }
}

/// Full weighting, the transpose of bilinear interpolation: a coarse cell collects its fine cells' residuals with
/// weights 1 3 3 1 / 4 in each direction (black residuals are zero). What falls outside the box is mirrored back.
void Multigrid::Grid::restrict_to(Grid& coarse) {
  const int NX = coarse.layout.nx, NY = coarse.layout.ny;
  float* even = row_a.data() + Layout::pad;
  float* odd = row_b.data() + Layout::pad;
  float* sum = row_c.data() + Layout::pad;
  for (int J = 0; J < NY; ++J) {
    const float* below = &residual[layout.row(0, 2 * J - 1)];
    const float* lower = &residual[layout.row(0, 2 * J)];
    const float* upper = &residual[layout.row(0, 2 * J + 1)];
    const float* above = &residual[layout.row(0, 2 * J + 2)];
    const float own_lower = J == 0 ? 0.75f + 0.25f * mirror[bottom] : 0.75f;
    const float own_upper = J == NY - 1 ? 0.75f + 0.25f * mirror[top] : 0.75f;
    for (int I = 0; I < NX; ++I) even[I] = own_lower * lower[I] + 0.25f * above[I];
    for (int I = 0; I < NX; ++I) odd[I] = 0.25f * below[I] + own_upper * upper[I];
    odd[-1] = mirror[left] * even[0];
    even[NX] = mirror[right] * odd[NX - 1];
    for (int I = 0; I < NX; ++I) sum[I] = 0.75f * (even[I] + odd[I]) + 0.25f * (odd[I - 1] + even[I + 1]);
    for (int colour = 0; colour < 2; ++colour) {
      float* f_row = &coarse.f[coarse.layout.row(colour, J)];
      const int parity = Layout::parity(colour, J);
      for (int k = 0; k < coarse.layout.row_length(colour, J); ++k) f_row[k] = sum[2 * k + parity];
    }
  }
  group_residual(coarse.charge);
  for (std::size_t m = 0; m < coarse.covered_cell.size(); ++m)
    coarse.charge[coarse.covered_group[m]] += coarse.f[coarse.covered_cell[m]];
}

/// Row J of the potential in natural order with a mirrored cell at each end.
void Multigrid::Grid::coarse_row(int J, float* row) const {
  const int inside = std::clamp(J, 0, layout.ny - 1);
  const float sign = J < 0 ? mirror[bottom] : J >= layout.ny ? mirror[top] : 1.0f;
  for (int colour = 0; colour < 2; ++colour) {
    const float* v_row = &v[layout.row(colour, inside)];
    const int parity = Layout::parity(colour, inside);
    for (int k = 0; k < layout.row_length(colour, inside); ++k) row[2 * k + parity] = sign * v_row[k];
  }
  row[-1] = mirror[left] * row[0];
  row[layout.nx] = mirror[right] * row[layout.nx - 1];
}

/// Adds the coarse correction, bilinearly interpolated, to the red cells (the black ones are relaxed next and forget
/// what they had).
void Multigrid::Grid::prolongate_from(const Grid& coarse) {
  const int NX = coarse.layout.nx, NY = coarse.layout.ny;
  std::vector<float> buffer(3 * (NX + 2 * Layout::pad));
  std::array<float*, 3> rows;
  for (int k = 0; k < 3; ++k) rows[k] = buffer.data() + k * (NX + 2 * Layout::pad) + Layout::pad;
  coarse.coarse_row(-1, rows[0]);
  coarse.coarse_row(0, rows[1]);
  for (int J = 0; J < NY; ++J) {
    coarse.coarse_row(J + 1, rows[2]);
    const float *below = rows[0], *own = rows[1], *above = rows[2];
    const std::ptrdiff_t lower = layout.row(0, 2 * J), upper = layout.row(0, 2 * J + 1);
    for (int I = 0; I < NX; ++I) {
      const float correction =
          0.75f * (0.75f * own[I] + 0.25f * own[I - 1]) + 0.25f * (0.75f * below[I] + 0.25f * below[I - 1]);
      v[lower + I] = inverse_diagonal[lower + I] > 0 ? v[lower + I] + correction : 0.0f;
    }
    for (int I = 0; I < NX; ++I) {
      const float correction =
          0.75f * (0.75f * own[I] + 0.25f * own[I + 1]) + 0.25f * (0.75f * above[I] + 0.25f * above[I + 1]);
      v[upper + I] = inverse_diagonal[upper + I] > 0 ? v[upper + I] + correction : 0.0f;
    }
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
  }
}

Multigrid::Multigrid(LinkFormula formula) : formula_(formula) {}
Multigrid::~Multigrid() = default;

int Multigrid::levels() const { return static_cast<int>(grids_.size()); }
long Multigrid::coarse_unknowns() const { return coarse_solver_->unknowns(); }

void Multigrid::prepare(const LaplaceProblem& problem, const Layout& finest) {
  if (!grids_.empty()) return;
  for (const GridSize& size : grid_sizes(problem, finest.nx, finest.ny)) {
    if (!grids_.empty()) coarse_levels_.push_back(std::make_unique<Level>(problem, size.nx, size.ny));
    grids_.emplace_back(Layout(size.nx, size.ny));
  }
  coarse_solver_ = std::make_unique<CoarseSolver>();
}

void Multigrid::build_coarse(const LaplaceProblem& problem) {
  for (std::size_t l = 0; l < coarse_levels_.size(); ++l) {
    coarse_levels_[l]->build(problem, formula_);
    grids_[l + 1].build(problem, *coarse_levels_[l]);
  }
  if (!coarse_levels_.empty()) coarse_solver_->factorize(problem, *coarse_levels_.back());
}

void Multigrid::build_finest(const LaplaceProblem& problem, const Level& finest) {
  grids_[0].build(problem, finest);
  if (coarse_levels_.empty()) coarse_solver_->factorize(problem, finest);
}

void Multigrid::apply(const double* r, double* z) {
  Grid& grid = grids_[0];
  const std::size_t cells = grid.layout.size();
  for (std::size_t k = 0; k < cells; ++k) grid.f[k] = static_cast<float>(r[k]);
  for (std::size_t g = 0; g < grid.charge.size(); ++g) grid.charge[g] = static_cast<float>(r[cells + g]);
  cycle(0);
  for (std::size_t k = 0; k < cells; ++k) z[k] = grid.v[k];
  for (std::size_t g = 0; g < grid.phi.size(); ++g) z[cells + g] = grid.phi[g];
}

void Multigrid::cycle(int l) {
  Grid& grid = grids_[l];
  if (l + 1 == levels()) {
    coarse_solver_->solve(grid.f.data(), grid.charge.data(), grid.v.data(), grid.phi.data());
    return;
  }
  Grid& coarse = grids_[l + 1];

  // Conductors first: a conductor's charge spreads into its potential before the cells see it. Without that the
  // sweep smooths against a wrong boundary (26 iterations of CG in place of 12).
  std::fill(grid.phi.begin(), grid.phi.end(), 0.0f);
  std::fill(grid.accumulator.begin(), grid.accumulator.end(), 0.0f);
  grid.relax_groups(true);
  grid.add_group_potentials(grid.phi);
  grid.sweep_from_zero();

  grid.restrict_to(coarse);
  cycle(l + 1);
  for (std::size_t m = 0; m < coarse.covered_cell.size(); ++m)
    coarse.v[coarse.covered_cell[m]] = coarse.phi[coarse.covered_group[m]];
  grid.prolongate_from(coarse);
  grid.add_group_potentials(coarse.phi);
  for (std::size_t g = 0; g < grid.phi.size(); ++g) grid.phi[g] += coarse.phi[g];

  // The mirror image of the first half: black, red, conductors.
  for (int j = 0; j <= grid.layout.ny; ++j) {
    if (j < grid.layout.ny) grid.relax(1, j);
    if (j >= 1) grid.relax(0, j - 1);
  }
  std::fill(grid.accumulator.begin(), grid.accumulator.end(), 0.0f);
  for (std::size_t m = 0; m < grid.link_cell.size(); ++m)
    grid.accumulator[grid.link_group[m]] += grid.link_conductance[m] * grid.v[grid.link_cell[m]];
  grid.relax_groups(false);
}

}  // namespace lichtenberg::laplace
