#include "solvers/laplace/cutcell/group_relaxation.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

void GroupRelaxation::build(const LaplaceProblem& problem, const Level& level, const std::vector<float>& diagonal) {
  inverse_diagonal_.assign(diagonal.size(), 0.0f);
  for (std::size_t g = 0; g < diagonal.size(); ++g)
    if (diagonal[g] > 0) inverse_diagonal_[g] = 1.0f / diagonal[g];
  direct_ = direct_links(problem, level);
  is_coupled_ = level.is_coupled();
  choose_block(level, diagonal);
  factorize_block(level, diagonal);
}

GroupRelaxation::DirectLinks GroupRelaxation::direct_links(const LaplaceProblem& problem, const Level& level) {
  const std::vector<NetworkLink> links = level.direct_links(problem);
  DirectLinks matrix;
  matrix.start.assign(problem.groups.size() + 1, 0);
  for (const auto& [a, b, conductance] : links) {
    ++matrix.start[a + 1];
    ++matrix.start[b + 1];
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g) matrix.start[g + 1] += matrix.start[g];
  matrix.other.resize(matrix.start.back());
  matrix.conductance.resize(matrix.start.back());
  std::vector<int> next(matrix.start.begin(), matrix.start.end() - 1);
  const auto put = [&](int g, int h, double c) {
    matrix.other[next[g]] = h;
    matrix.conductance[next[g]++] = static_cast<float>(c);
  };
  for (const auto& [a, b, conductance] : links) {
    put(a, b, conductance);
    put(b, a, conductance);
  }
  return matrix;
}

/// Marks groups with a direct link (gap conductance) that outweighs the links to cells of either of its groups.
std::vector<char> GroupRelaxation::strongly_linked(const std::vector<float>& diagonal) const {
  const int groups = static_cast<int>(diagonal.size());
  std::vector<char> strong(groups, 0);
  const auto to_cells = [&](int g) {
    float sum = diagonal[g];
    for (int m = direct_.start[g]; m < direct_.start[g + 1]; ++m) sum -= direct_.conductance[m];
    return sum;
  };
  for (int g = 0; g < groups; ++g) {
    if (direct_.start[g] == direct_.start[g + 1] || diagonal[g] == 0) continue;
    for (int m = direct_.start[g]; m < direct_.start[g + 1] && !strong[g]; ++m) {
      const int h = direct_.other[m];
      strong[g] = diagonal[h] > 0 && 4 * direct_.conductance[m] >= std::min(to_cells(g), to_cells(h));
    }
  }
  return strong;
}

void GroupRelaxation::choose_block(const Level& level, const std::vector<float>& diagonal) {
  const int groups = static_cast<int>(diagonal.size());
  std::vector<char> in_block = strongly_linked(diagonal);
  for (const NetworkLink& coupling : level.couplings) in_block[coupling.a] = in_block[coupling.b] = 1;
  for (const FixedCoupling& coupling : level.fixed_couplings) in_block[coupling.group] = 1;
  block_.clear();
  index_in_block_.assign(groups, -1);
  for (int g = 0; g < groups; ++g) {
    if (!in_block[g]) continue;
    index_in_block_[g] = static_cast<int>(block_.size());
    block_.push_back(g);
  }
}

void GroupRelaxation::factorize_block(const Level& level, const std::vector<float>& diagonal) {
  std::vector<double> ground(block_.size());
  std::vector<NetworkLink> links;
  for (const int g : block_) {
    double& to_ground = ground[index_in_block_[g]];
    to_ground = diagonal[g];
    for (int m = direct_.start[g]; m < direct_.start[g + 1]; ++m) {
      const int h = direct_.other[m];
      if (index_in_block_[h] < 0) continue;
      to_ground -= direct_.conductance[m];
      if (g < h) links.push_back({index_in_block_[g], index_in_block_[h], direct_.conductance[m]});
    }
    to_ground = std::max(0.0, to_ground);
  }
  for (const auto& [a, b, conductance] : level.couplings)
    links.push_back({index_in_block_[a], index_in_block_[b], conductance});
  for (const FixedCoupling& coupling : level.fixed_couplings)
    ground[index_in_block_[coupling.group]] += coupling.conductance_in_cycle;
  block_factors_ = NetworkFactors(std::move(ground), links);
  block_phi_.assign(block_.size(), 0.0);
  block_flux_.assign(block_.size(), 0.0);
}

/// Returns the flux into a group of the block, through direct links (gap conductances), from groups outside the block.
double GroupRelaxation::flux_from_outside(int group, const std::vector<float>& phi) const {
  double flux = 0;
  for (int m = direct_.start[group]; m < direct_.start[group + 1]; ++m)
    if (const int h = direct_.other[m]; index_in_block_[h] < 0) flux += direct_.conductance[m] * phi[h];
  return flux;
}

void GroupRelaxation::relax_block(const std::vector<float>& charge, const std::vector<float>& flux,
                                  std::vector<float>& phi) {
  for (std::size_t k = 0; k < block_.size(); ++k) {
    const int g = block_[k];
    block_flux_[k] = static_cast<double>(flux[g]) + flux_from_outside(g, phi);
    block_phi_[k] = charge[g] + block_flux_[k];
  }
  block_factors_.solve(block_phi_.data());
  for (std::size_t k = 0; k < block_.size(); ++k) phi[block_[k]] = static_cast<float>(block_phi_[k]);
}

void GroupRelaxation::relax(bool forward, const std::vector<float>& charge, const std::vector<float>& flux,
                            std::vector<float>& phi) {
  const int groups = static_cast<int>(phi.size());
  if (!forward) relax_block(charge, flux, phi);
  for (int k = 0; k < groups; ++k) {
    const int g = forward ? k : groups - 1 - k;
    if (index_in_block_[g] >= 0) continue;
    float sum = charge[g] + flux[g];
    for (int m = direct_.start[g]; m < direct_.start[g + 1]; ++m) sum += direct_.conductance[m] * phi[direct_.other[m]];
    phi[g] = sum * inverse_diagonal_[g];
  }
  if (forward) relax_block(charge, flux, phi);
}

void GroupRelaxation::complete_residuals(const std::vector<float>& phi, const std::vector<float>& flux,
                                         std::vector<float>& residual) const {
  for (std::size_t g = 0; g < phi.size(); ++g) {
    for (int m = direct_.start[g]; m < direct_.start[g + 1]; ++m)
      residual[g] += direct_.conductance[m] * phi[direct_.other[m]];
    residual[g] = inverse_diagonal_[g] > 0 ? residual[g] - phi[g] / inverse_diagonal_[g] : 0.0f;
  }
  if (!is_coupled_) return;
  for (std::size_t k = 0; k < block_.size(); ++k) {
    const int g = block_[k];
    residual[g] = static_cast<float>(flux[g] + flux_from_outside(g, phi) - block_flux_[k]);
  }
}

}  // namespace lichtenberg::laplace
