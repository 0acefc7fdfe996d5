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

/// One grid of the multigrid V-cycle in single precision: its linear system, its vectors and the passes of the cycle.
/// Unknowns are the potentials of fluid cells and of floating groups (bodies with one potential), except groups in an
/// effective medium. Passes over cells run in bands of rows on a thread team (wavefront.hpp). In a slab, a pass begins
/// with an exchange of ghost rows and computes the values in ghost rows that its later stages need. Values of groups
/// are the same in all processes.
class Grid {
 public:
  /// Makes a grid of the V-cycle. `sweeps`: number of smoothing sweeps before the correction from the next coarser
  /// grid, and after it.
  Grid(const Layout& at, int sweeps, parallel::Team& team);

  /// Copies the system of the discretized grid `level` in single precision: diagonals, face conductances, links, groups
  /// (bodies with one potential). The threads of `team` do the work; the team may differ from that of the passes.
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team);

  /// Applies the smoother (red-black Gauss-Seidel relaxation) to the potentials v and phi from zero, for the right-hand
  /// sides f and `charge`. It then computes the residual. The order of relaxation is groups (bodies with one
  /// potential), red cells, black cells.
  void smooth_from_zero();
  /// Restricts the residual to the right-hand sides `f` and `charge` of the next coarser grid (full weighting).
  void restrict_to(Grid& coarse);
  /// Adds the coarse-grid correction of `coarse`, which must have called spread(), then smooths. The order of
  /// relaxation is black cells, red cells, groups (bodies with one potential). If r is not null, row_product[j] becomes
  /// the scalar product of r and v over row j.
  void correct_and_smooth(const Grid& coarse, const double* r = nullptr, double* row_product = nullptr);
  /// Distributes the right-hand sides `charge` of absorbed groups to f of the four cells around each group, and sets
  /// these entries of `charge` to 0. An absorbed group has no unknown on this grid. A group is a set of bodies with one
  /// potential.
  void absorb_charges(std::span<const AbsorbedGroup> groups);
  /// Prepares the potentials v for interpolation to the next finer grid (prolongation). Covered cells get their group's
  /// entry of `potential`. Groups that this grid absorbs, but not the next finer grid, get the interpolated potential
  /// in phi. Mirror images of cells beyond a side are multiplied by mirrored[side]. A group is a set of bodies with one
  /// potential.
  void spread(const std::vector<float>& potential, const std::array<float, 4>& mirrored);
  /// Prolongation: sets v to the bilinear interpolation from the next coarser grid, which must have called spread(),
  /// and phi to that grid's group potentials. A group is a set of bodies with one potential.
  void interpolate_from(const Grid& coarse);
  /// If couplings (lumped capacitances) exist, solves for the potentials phi of the groups that couplings or strong gap
  /// conductances join. `charge` and the cells' potentials v are given. A group is a set of bodies with one potential.
  void solve_coupled_groups();
  /// Returns the potential of a group (bodies with one potential), in double precision for groups with couplings
  /// (lumped capacitances).
  double potential_of(int group) const { return groups_.potential(group, phi); }
  /// Solves for coupled groups (bodies with one potential), then replaces the right-hand sides f and `charge` by the
  /// residuals of v and phi.
  void form_residual();

  Layout layout;
  /// Potentials and right-hand sides of cells, by slot (memory index).
  std::vector<float> v, f;
  /// Potentials and right-hand sides of groups; 0 for groups of given potential.
  std::vector<float> phi, charge;
  /// Sign of a correction's mirror image beyond each side of the box: +1 at an insulating side, -1 at an electrode.
  std::array<float, 4> mirror{};

 private:
  template <class Effect>
  void with_neighbours(int colour, int j, const Effect& effect) const;
  void relax(int colour, int j);
  float flux_from_neighbours(const EliminatedCells::Cell& cell) const;
  void update_eliminated(int colour, int j);
  void relax_groups_again(bool forward);
  int ghosts_before(int sweep) const;
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
