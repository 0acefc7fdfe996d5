#pragma once

#include <vector>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/network_factors.hpp"

namespace lichtenberg::laplace {

/// Gauss-Seidel relaxation of the floating groups' equations on one grid. A floating group is a set of bodies with one
/// unknown potential. Groups with couplings (lumped capacitances) or strong direct links (gap conductances) are solved
/// together as one block. Sequential relaxation would retain the common potential of a chain of such groups, and CG's
/// natural norm would not show it. Vectors have one entry a group: potentials `phi`, right-hand sides `charge`, fluxes
/// from cells `flux`.
class GroupRelaxation {
 public:
  /// Chooses and factorizes the block of coupled groups, and lists the direct links (gap conductances). `diagonal`
  /// [groups]: sum of each group's conductances without couplings (lumped capacitances); 0 for groups of given
  /// potential. A group is a set of bodies with one potential.
  void build(const LaplaceProblem& problem, const Level& level, const std::vector<float>& diagonal);

  /// Computes new potentials phi by one Gauss-Seidel sweep. It relaxes the single groups (bodies with one potential) in
  /// their order, then the block. If `forward` is false, the order is reversed, so that the cycle is symmetric.
  void relax(bool forward, const std::vector<float>& charge, const std::vector<float>& flux, std::vector<float>& phi);
  /// Solves for the potentials phi of the groups (bodies with one potential) in the block; the other groups' potentials
  /// stay.
  void relax_block(const std::vector<float>& charge, const std::vector<float>& flux, std::vector<float>& phi);
  /// Completes the groups' residuals in `residual`, which must contain charge + flux from cells. Adds the fluxes
  /// through direct links (gap conductances) and subtracts diagonal * phi. If couplings exist, the residual of a group
  /// of the block is the change of its flux since the block's relaxation, where it was zero. Only these groups use
  /// `flux` [groups], the flux from cells. A group is a set of bodies with one potential.
  void complete_residuals(const std::vector<float>& phi, const std::vector<float>& flux,
                          std::vector<float>& residual) const;

  /// Returns true if couplings (lumped capacitances) exist. The residuals and potentials of the block are then computed
  /// in double precision, because strong couplings would amplify rounding errors.
  bool is_coupled() const { return is_coupled_; }
  /// Returns the potential of a group (bodies with one potential). With couplings (lumped capacitances) it is in double
  /// precision for groups of the block, otherwise from `phi`.
  double potential(int group, const std::vector<float>& phi) const {
    return is_coupled_ && index_in_block_[group] >= 0 ? block_phi_[index_in_block_[group]] : phi[group];
  }

 private:
  /// Direct links (conductances between two groups) as a sparse matrix by rows. `start` [groups + 1]: index of a
  /// group's first entry in `other` and `conductance`. A group is a set of bodies with one potential.
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
