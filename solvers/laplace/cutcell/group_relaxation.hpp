#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/network_factors.hpp"

namespace lichtenberg::laplace {

/// Relaxation of a grid's floating groups: Gauss-Seidel, with one block for groups that couplings or strong direct
/// links connect. Sequential relaxation of those would retain the common potential of a chain of groups, and CG's
/// natural norm would not show it. Vectors have one entry a group: `phi` potentials, `charge` right-hand sides, `flux`
/// fluxes from cells.
class GroupRelaxation {
 public:
  /// Sets up the relaxation of a level's groups. `diagonal`: sum of each group's conductances without couplings; 0 for
  /// groups of given potential.
  void build(const LaplaceProblem& problem, const Level& level, const std::vector<float>& diagonal);

  /// Sets phi: the single groups in their order, then the block, or in the reverse order if not `forward`.
  void relax(bool forward, const std::vector<float>& charge, const std::vector<float>& flux, std::vector<float>& phi);
  /// Sets phi of the block only.
  void relax_block(const std::vector<float>& charge, const std::vector<float>& flux, std::vector<float>& phi);
  /// Completes residuals: adds fluxes through direct links and subtracts diagonal x phi. `residual` contains charge +
  /// flux. Residuals of coupled groups are set to the change of their flux since their relaxation, because they were
  /// zero then. `flux` is used for those only.
  void complete_residuals(const std::vector<float>& phi, const std::vector<float>& flux,
                          std::vector<float>& residual) const;

  /// Returns true if couplings exist. Coupled groups are then relaxed together, as one block in double precision:
  /// strong couplings would amplify rounding errors.
  bool is_coupled() const { return is_coupled_; }
  /// Returns the potential of a group: in double precision from the block if the group is in it, otherwise from `phi`.
  double potential(int group, const std::vector<float>& phi) const {
    return is_coupled_ && index_in_block_[group] >= 0 ? block_phi_[index_in_block_[group]] : phi[group];
  }

 private:
  /// Direct links as a sparse matrix over groups. [groups + 1]: a group's first in the other two.
  struct DirectLinks {
    std::vector<int> start, other;
    std::vector<float> conductance;
  };
  static DirectLinks direct_links(const LaplaceProblem& problem, const Level& level);
  std::vector<char> strongly_linked(const std::vector<float>& diagonal) const;
  void choose_block(const Level& level, const std::vector<float>& diagonal);
  void factorize_block(const Level& level, const std::vector<float>& diagonal);
  double flux_from_outside(int group, const std::vector<float>& phi) const;

  DirectLinks direct_;
  // 0 for groups of given potential.
  std::vector<float> inverse_diagonal_;
  bool is_coupled_ = false;
  // Groups of the block; by group the index in it, or -1.
  std::vector<int> block_, index_in_block_;
  NetworkFactors block_factors_;
  // Potentials of the block, and fluxes from cells and other groups at its last relaxation.
  std::vector<double> block_phi_, block_flux_;
};

}  // namespace lichtenberg::laplace
