#include "solvers/laplace/cutcell/multigrid.hpp"

#include <algorithm>
#include <utility>

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/coarse.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

Multigrid::Multigrid(LinkFormula formula, parallel::Team& team, int coarse_sweeps)
    : formula_(formula), team_(team), coarse_sweeps_(coarse_sweeps) {}
Multigrid::~Multigrid() = default;

int Multigrid::levels() const { return static_cast<int>(grids_.size()); }

void Multigrid::prepare(const LaplaceProblem& problem, const Layout& finest) {
  if (!grids_.empty()) return;
  const int process = finest.is_divided() ? parallel::process_rank() : 0;
  const int processes = finest.is_divided() ? parallel::process_count() : 1;
  for (const Layout& layout : grid_layouts(finest.nx, finest.ny, process, processes)) {
    if (!grids_.empty()) coarse_levels_.push_back(std::make_unique<Level>(problem, layout));
    if (grids_.empty())
      grids_.push_back(std::make_unique<Grid>(finest, 1, team_));
    else
      grids_.push_back(std::make_unique<Grid>(coarse_levels_.back()->layout, coarse_sweeps_, team_));
  }
  coarse_builders_.resize(coarse_levels_.size());
  coarse_solver_ = std::make_unique<CoarseSolver>();
  row_product_.resize(finest.ny);
}

void Multigrid::build_coarse(const LaplaceProblem& problem, const Level& finest) {
  if (coarse_levels_.empty()) return;
  const auto factorize = [&] { coarse_solver_->factorize(problem, *coarse_levels_.back()); };
  // The set-up of the coarse grids takes less time than that of the finest: enough work for one of two threads, but too
  // much for one of three. Exchanges between processes are calls of one thread.
  if (team_.size() == 2 && !finest.layout.is_divided())
    return team_.start([this, &problem, &finest, factorize] {
      discretize_coarse(problem, finest, parallel::Team::single());
      factorize();
    });
  discretize_coarse(problem, finest, team_);
  team_.start(factorize);
}

void Multigrid::discretize_coarse(const LaplaceProblem& problem, const Level& finest, parallel::Team& team) {
  const Agglomerates agglomerates = find_agglomerates(problem, finest.direct_links(problem));
  for (std::size_t l = 0; l < coarse_levels_.size(); ++l) {
    const Level* finer = l > 0 ? coarse_levels_[l - 1].get() : &finest;
    coarse_builders_[l].build_coarse(problem, formula_, agglomerates, finer, *coarse_levels_[l], team);
    grids_[l + 1]->build(problem, *coarse_levels_[l], team);
  }
}

void Multigrid::build_finest(const LaplaceProblem& problem, const Level& finest) {
  grids_[0]->build(problem, finest, team_);
  if (coarse_levels_.empty()) coarse_solver_->factorize(problem, finest);
}

void Multigrid::take_row(int j, const double* r) {
  Grid& grid = *grids_[0];
  for (int colour = 0; colour < 2; ++colour) {
    const double* __restrict from = r + grid.layout.row(colour, j);
    float* __restrict to = &grid.f[grid.layout.row(colour, j)];
    for (int k = 0; k < grid.layout.row_length(colour, j); ++k) to[k] = static_cast<float>(from[k]);
  }
}

void Multigrid::take_groups(const double* r) {
  Grid& grid = *grids_[0];
  const double* r_group = r + grid.layout.size();
  for (std::size_t g = 0; g < grid.charge.size(); ++g) grid.charge[g] = static_cast<float>(r_group[g]);
}

double Multigrid::cycle(const double* r) {
  cycle(0, r, row_product_.data());
  Grid& grid = *grids_[0];
  exchange_ghosts(grid.layout, grid.v.data(), 1);
  if (levels() == 1) grid.solve_coupled_groups();
  group_potential_.resize(grid.phi.size());
  for (std::size_t g = 0; g < grid.phi.size(); ++g) group_potential_[g] = grid.potential_of(static_cast<int>(g));
  const double* r_group = r + grid.layout.size();
  double product = 0;
  if (levels() > 1) {
    product = ordered_sum(grid.layout, row_product_);
  } else {
    for (std::ptrdiff_t k = 0; k < grid.layout.size(); ++k) product += r[k] * grid.v[k];
  }
  for (std::size_t g = 0; g < grid.phi.size(); ++g) product += r_group[g] * group_potential_[g];
  return product;
}

void Multigrid::apply(const double* r, double* z) {
  const Grid& grid = *grids_[0];
  for_each_row(team_, grid.layout, [&](int j) { take_row(j, r); });
  take_groups(r);
  cycle(r);
  std::copy(grid.v.begin(), grid.v.end(), z);
  std::copy(group_potential_.begin(), group_potential_.end(), z + grid.v.size());
}

/// Returns the number of cells of grid l relative to the finest grid.
double Multigrid::share(int l) const {
  const Layout &at = grids_[l]->layout, &finest = grids_[0]->layout;
  return static_cast<double>(at.nx) * at.ny / (static_cast<double>(finest.nx) * finest.ny);
}

double Multigrid::take_work() { return std::exchange(work_, 0.0); }

void Multigrid::spread_correction(int l) { grids_[l]->spread(grids_[l]->phi, grids_[l]->mirror); }

void Multigrid::cycle(int l, const double* r, double* row_product) {
  Grid& grid = *grids_[l];
  if (l + 1 == levels()) {
    coarse_solver_->solve(grid.f.data(), grid.charge.data(), grid.v.data(), grid.phi.data());
    return;
  }
  const int more_sweeps = l == 0 ? 0 : coarse_sweeps_ - 1;
  grid.smooth_from_zero();
  // Black cells, and the residual in red cells; the first values of red cells need no stencil.
  work_ += (1 + more_sweeps) * share(l);
  grid.restrict_to(*grids_[l + 1]);
  work_ += 0.5 * share(l);
  cycle(l + 1, nullptr, nullptr);
  spread_correction(l + 1);
  grid.correct_and_smooth(*grids_[l + 1], r, row_product);
  work_ += (1.5 + more_sweeps) * share(l);  // interpolation to the red cells, black cells, red cells
}

void Multigrid::nested_guess(const LaplaceProblem& problem, double scale, double* x) {
  if (levels() == 1) return;
  const std::array<float, 4> continued{1, 1, 1, 1};
  std::vector<float> potential(problem.groups.size());
  for (int l = levels() - 1; l > 0; --l) {
    Grid& grid = *grids_[l];
    const Level& level = *coarse_levels_[l - 1];
    write_right_hand_side(problem, level, scale, grid.f.data(), grid.charge.data());
    grid.absorb_charges(level.absorbed);
    if (l + 1 == levels()) {
      cycle(l, nullptr, nullptr);
    } else {
      grid.interpolate_from(*grids_[l + 1]);
      grid.form_residual();
      work_ += 2 * share(l);
      const std::vector<float> guess = grid.v, guess_phi = grid.phi;
      cycle(l, nullptr, nullptr);
      for (std::size_t k = 0; k < guess.size(); ++k) grid.v[k] += guess[k];
      for (std::size_t g = 0; g < guess_phi.size(); ++g) grid.phi[g] += guess_phi[g];
    }
    for (std::size_t g = 0; g < potential.size(); ++g)
      potential[g] = problem.groups[g].floating ? grid.phi[g] : static_cast<float>(problem.groups[g].potential / scale);
    grid.spread(potential, continued);
  }
  Grid& finest = *grids_[0];
  finest.interpolate_from(*grids_[1]);
  work_ += 1;
  std::copy(finest.v.begin(), finest.v.end(), x);
  std::copy(finest.phi.begin(), finest.phi.end(), x + finest.v.size());
}

}  // namespace lichtenberg::laplace
