// How a grid of the cycle relaxes groups: Gauss-Seidel, and groups with strong direct links or couplings as one block.

#include <algorithm>

#include "solvers/laplace/cutcell/grid.hpp"

namespace lichtenberg::laplace {

Grid::GroupCoupling Grid::couple_groups(const LaplaceProblem& problem, const Level& level) {
  const std::vector<NetworkLink> direct = level.direct_links(problem);
  GroupCoupling coupling;
  coupling.start.assign(problem.groups.size() + 1, 0);
  for (const auto& [a, b, conductance] : direct) {
    ++coupling.start[a + 1];
    ++coupling.start[b + 1];
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g) coupling.start[g + 1] += coupling.start[g];
  coupling.other.resize(coupling.start.back());
  coupling.conductance.resize(coupling.start.back());
  std::vector<int> next(coupling.start.begin(), coupling.start.end() - 1);
  const auto put = [&](int g, int h, double c) {
    coupling.other[next[g]] = h;
    coupling.conductance[next[g]++] = static_cast<float>(c);
  };
  for (const auto& [a, b, conductance] : direct) {
    put(a, b, conductance);
    put(b, a, conductance);
  }
  return coupling;
}

/// Groups with a direct link that outweighs their links to cells.
std::vector<char> Grid::strongly_paired(const std::vector<float>& group_diagonal) const {
  const int groups = static_cast<int>(phi.size());
  std::vector<char> strong(groups, 0);
  const auto to_cells = [&](int g) {
    float sum = group_diagonal[g];
    for (int m = coupling_.start[g]; m < coupling_.start[g + 1]; ++m) sum -= coupling_.conductance[m];
    return sum;
  };
  for (int g = 0; g < groups; ++g) {
    if (coupling_.start[g] == coupling_.start[g + 1] || group_diagonal[g] == 0) continue;
    for (int m = coupling_.start[g]; m < coupling_.start[g + 1] && !strong[g]; ++m) {
      const int h = coupling_.other[m];
      strong[g] = group_diagonal[h] > 0 && 4 * coupling_.conductance[m] >= std::min(to_cells(g), to_cells(h));
    }
  }
  return strong;
}

/// The strongly paired groups, and those that the problem couples, are relaxed as one block: one after the other they
/// would not get rid of what is common to a chain of them, and CG's natural norm would not notice.
void Grid::choose_block(const Level& level, const std::vector<float>& group_diagonal) {
  const int groups = static_cast<int>(phi.size());
  std::vector<char> in_block = strongly_paired(group_diagonal);
  for (const NetworkLink& coupling : level.couplings) in_block[coupling.a] = in_block[coupling.b] = 1;
  for (const FixedCoupling& coupling : level.fixed_couplings) in_block[coupling.group] = 1;
  is_coupled_ = level.is_coupled();
  block_.clear();
  place_in_block_.assign(groups, -1);
  for (int g = 0; g < groups; ++g) {
    if (!in_block[g]) continue;
    place_in_block_[g] = static_cast<int>(block_.size());
    block_.push_back(g);
  }
  factorize_block(level, group_diagonal);
}

void Grid::factorize_block(const Level& level, const std::vector<float>& group_diagonal) {
  std::vector<double> ground(block_.size());
  std::vector<NetworkLink> links;
  for (const int g : block_) {
    double& to_ground = ground[place_in_block_[g]];
    to_ground = group_diagonal[g];
    for (int m = coupling_.start[g]; m < coupling_.start[g + 1]; ++m) {
      const int h = coupling_.other[m];
      if (place_in_block_[h] < 0) continue;
      to_ground -= coupling_.conductance[m];
      if (g < h) links.push_back({place_in_block_[g], place_in_block_[h], coupling_.conductance[m]});
    }
    to_ground = std::max(0.0, to_ground);
  }
  for (const auto& [a, b, conductance] : level.couplings)
    links.push_back({place_in_block_[a], place_in_block_[b], conductance});
  for (const FixedCoupling& coupling : level.fixed_couplings)
    ground[place_in_block_[coupling.group]] += coupling.conductance_in_cycle;
  block_factors_ = NetworkFactors(std::move(ground), links);
  block_phi_.assign(block_.size(), 0.0);
  block_flux_.assign(block_.size(), 0.0);
}

/// What groups outside the block bring a group in it.
double Grid::flux_from_outside(int group) const {
  double flux = 0;
  for (int m = coupling_.start[group]; m < coupling_.start[group + 1]; ++m)
    if (const int h = coupling_.other[m]; place_in_block_[h] < 0) flux += coupling_.conductance[m] * phi[h];
  return flux;
}

void Grid::relax_block() {
  for (std::size_t k = 0; k < block_.size(); ++k) {
    const int g = block_[k];
    block_flux_[k] = static_cast<double>(flux_[g]) + flux_from_outside(g);
    block_phi_[k] = charge[g] + block_flux_[k];
  }
  block_factors_.solve(block_phi_.data());
  for (std::size_t k = 0; k < block_.size(); ++k) phi[block_[k]] = static_cast<float>(block_phi_[k]);
}

/// Each group's potential from its charge, its cells' flux_ and the groups it is coupled with directly: Gauss-Seidel,
/// and the block as a whole, last if `forward`, and in the reverse order if not.
void Grid::relax_groups(bool forward) {
  const int groups = static_cast<int>(phi.size());
  if (!forward) relax_block();
  for (int k = 0; k < groups; ++k) {
    const int g = forward ? k : groups - 1 - k;
    if (place_in_block_[g] >= 0) continue;
    float flux = charge[g] + flux_[g];
    for (int m = coupling_.start[g]; m < coupling_.start[g + 1]; ++m)
      flux += coupling_.conductance[m] * phi[coupling_.other[m]];
    phi[g] = flux * group_inverse_diagonal_[g];
  }
  if (forward) relax_block();
}

/// What cells bring the groups, bound ones without what these give back at once.
void Grid::add_cell_fluxes(std::vector<float>& sum) const {
  links_.add_to_groups(*team_, v.data(), sum.data());
  add_bound_fluxes(sum);
}

/// The groups once more, after a sweep; flux_ becomes what their change is.
void Grid::relax_groups_again(bool forward) {
  phi_before_ = phi;
  std::fill(flux_.begin(), flux_.end(), 0.0f);
  if (forward)
    for (int j = 0; j < layout.ny; ++j) note_bound(0, j);
  add_cell_fluxes(flux_);
  relax_groups(forward);
  for (std::size_t g = 0; g < phi.size(); ++g) flux_[g] = phi[g] - phi_before_[g];
}

}  // namespace lichtenberg::laplace
