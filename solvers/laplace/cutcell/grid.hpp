#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/laplace/cutcell/covered_cells.hpp"
#include "solvers/laplace/cutcell/group_relaxation.hpp"
#include "solvers/laplace/cutcell/kron_reduction.hpp"
#include "solvers/laplace/cutcell/link_lists.hpp"
#include "solvers/laplace/cutcell/mirrored_rows.hpp"

namespace lichtenberg::laplace {

/// One grid of the multigrid cycle in single precision: its system, its vectors and the passes of a cycle. Passes over
/// cells run in bands of rows on the team (wavefront.hpp).
class Grid {
 public:
  /// Makes a grid of the V-cycle. `sweeps`: number of sweeps over the cells before the correction from the next coarser
  /// grid, and after it.
  Grid(const Layout& at, int sweeps, parallel::Team& team);

  /// Takes over the level's system. `team` may differ from the team of the passes.
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team);

  /// Smooths f and charge from zero (conductors, red cells, black cells) and computes the residual.
  void smooth_from_zero();
  /// Restricts the residual to the right-hand side of `coarse`.
  void restrict_to(Grid& coarse);
  /// Adds the correction of `coarse` after its `spread`, then smooths: black cells, red cells, conductors. Sets
  /// row_product[j] to r'v over row j unless r is null.
  void correct_and_smooth(const Grid& coarse, const double* r = nullptr, double* row_product = nullptr);
  /// Moves the charges of these groups to the cells around them.
  void absorb_charges(std::span<const AbsorbedGroup> groups);
  /// Prepares v as source of an interpolation. Covered cells get their group's entry of `potential`; the mirror image
  /// beyond a side is multiplied by mirrored[side]. Also interpolates phi of newly absorbed groups.
  void spread(const std::vector<float>& potential, const std::array<float, 4>& mirrored);
  /// Sets v to the interpolation from `coarse` after its `spread`, and phi to that of `coarse`.
  void interpolate_from(const Grid& coarse);
  /// Solves for the potentials of coupled groups, given charge and v.
  void solve_coupled_groups();
  /// Potential of a group; of coupled ones in double precision.
  double potential_of(int group) const { return groups_.potential(group, phi); }
  /// Replaces f and charge by the residual of v and phi.
  void form_residual();

  Layout layout;
  /// Potentials and right-hand sides of cells, by slot.
  std::vector<float> v, f;
  /// Potentials and right-hand sides of groups; 0 where the potential is given.
  std::vector<float> phi, charge;
  /// Sign of a correction's mirror image: +1 at an insulating side, -1 at an electrode.
  std::array<float, 4> mirror{};

 private:
  template <class Effect>
  void with_neighbours(int colour, int j, const Effect& effect) const;
  void relax(int colour, int j);
  float flux_from_neighbours(const EliminatedCells::Cell& cell) const;
  void update_eliminated(int colour, int j);
  void relax_groups_again(bool forward);
  void add_link_fluxes(int j, const std::vector<float>& potential);
  void add_cell_fluxes(std::vector<float>& sum) const;
  void add_correction(const Grid& coarse, int j);
  double row_dot_of_cells(const double* r, int j) const;
  void add_group_residuals(std::vector<float>& charges) const;
  template <class Effect>
  void interpolate_row(const Grid& coarse, int colour, int j, const Effect& effect) const;
  void restrict_row(Grid& coarse, int J) const;
  void restrict_groups(Grid& coarse);

  int sweeps_;
  parallel::Team* team_;
  FaceConductances faces_;
  // By slot; 0 where there is no unknown.
  std::vector<float> inverse_diagonal_;
  // By slot, red cells only.
  std::vector<float> residual_;
  // Sums over groups leave out links of eliminated cells.
  LinkLists<float> links_;
  KronReduction eliminated_;
  GroupRelaxation groups_;
  // By group: flux from cells, then the change of potential in the last relaxation.
  std::vector<float> flux_;
  std::vector<AbsorbedGroup> newly_absorbed_;
  CoveredCells covered_;
  MirroredRows mirrored_;
};

}  // namespace lichtenberg::laplace
