#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/laplace/cutcell/link_lists.hpp"

namespace lichtenberg::laplace {

/// One grid of the multigrid cycle: its system and its vectors, in single precision, and the passes that a cycle is
/// made of. Every pass over cells runs in bands of rows on the team (wavefront.hpp).
class Grid {
 public:
  /// `sweeps` over the cells go before, and as many after, the correction from the next coarser grid.
  Grid(const Layout& at, int sweeps, parallel::Team& team);

  /// On `team`, which may be another than the passes'.
  void build(const LaplaceProblem& problem, const Level& level, parallel::Team& team);

  /// Smooths f and charge from zero (conductors, red cells, black cells) and finds the residual.
  void smooth_from_zero();
  /// Sends the residual to the right-hand side of `coarse`.
  void restrict_to(Grid& coarse);
  /// Adds the correction of `coarse` after its `spread`, then smooths: black cells, red cells, conductors. With r,
  /// row_product[j] is set to r'v over row j.
  void correct_and_smooth(const Grid& coarse, const double* r = nullptr, double* row_product = nullptr);
  /// Moves the charges of these groups to the cells around them.
  void absorb_charges(std::span<const AbsorbedGroup> groups);
  /// Writes v by row and column into `natural`, covered cells with their group's entry of `potential`; beyond a side
  /// lies the mirror image, multiplied by mirrored[side]. Groups that the finer grid has and this one has absorbed get
  /// their phi.
  void spread(const std::vector<float>& potential, const std::array<float, 4>& mirrored);
  /// v = what `coarse` has after its `spread`, interpolated to all fluid cells; phi = that of `coarse`.
  void interpolate_from(const Grid& coarse);
  /// Sets coupled groups to what charge and v make of them.
  void settle_coupled();
  /// phi, where groups are coupled in double precision: a strong coupling would make much of its rounding.
  double potential_of(int group) const {
    return is_coupled_ && place_in_block_[group] >= 0 ? block_phi_[place_in_block_[group]] : phi[group];
  }
  /// f and charge become the residual of v and phi.
  void form_residual();

  Layout layout;
  std::vector<float> v, f;         // by slot
  std::vector<float> phi, charge;  // by group; 0 where the potential is given
  std::array<float, 4> mirror{};   // +1 at an insulating side, -1 at an electrode: what a correction continues as

 private:
  /// Groups coupled directly, by pair links and bound cells, as a sparse matrix over groups.
  struct GroupCoupling {
    std::vector<int> start, other;
    std::vector<float> conductance;
  };
  static GroupCoupling couple_groups(const LaplaceProblem& problem, const Level& level);
  template <class Effect>
  void with_neighbours(int colour, int j, const Effect& effect) const;
  void relax(int colour, int j);
  std::vector<char> strongly_paired(const std::vector<float>& group_diagonal) const;
  void choose_block(const Level& level, const std::vector<float>& group_diagonal);
  void factorize_block(const Level& level, const std::vector<float>& group_diagonal);
  double flux_from_outside(int group) const;
  void relax_block();
  void relax_groups(bool forward);
  void relax_groups_again(bool forward);
  void build_bound(const Level& level, std::vector<float>& group_diagonal);
  void start_bound();
  float flux_from_cells(const BoundCells::Cell& cell) const;
  void note_bound(int colour, int j);
  void take_bound_as_relaxed();
  void set_bound_residuals(int j);
  void add_bound_fluxes(std::vector<float>& sum) const;
  void add_cell_fluxes(std::vector<float>& sum) const;
  void follow_groups(const double* r, double* row_product);
  void add_link_fluxes(int j, const std::vector<float>& potential);
  void add_correction(const Grid& coarse, int j);
  double row_dot_of_cells(const double* r, int j) const;
  void add_group_charges(std::vector<float>& sum) const;
  template <class Effect>
  void interpolate_row(const Grid& coarse, int colour, int j, const Effect& effect) const;
  void restrict_row(Grid& coarse, int J) const;
  void restrict_groups(Grid& coarse);
  const float* natural_row(int j) const { return &natural_[(j + 1) * natural_stride_ + Layout::pad]; }

  int sweeps_;
  parallel::Team* team_;
  LinkLists<float> links_;  // those of bound cells not in the sums over groups
  BoundCells bound_;
  std::vector<int> bound_row_;                // [ny + 1] a row's first of bound_.cells
  std::vector<double> bound_share_;           // by link, of a bound cell's flux that goes to the link's group
  std::vector<double> bound_f_, bound_flux_;  // f; f and what cells brought a bound cell when it was relaxed last
  std::vector<float> residual_;               // by slot, red cells only
  std::vector<float> inverse_diagonal_;       // by slot; 0 where there is no unknown
  std::vector<float> group_inverse_diagonal_, flux_, phi_before_;
  GroupCoupling coupling_;
  std::vector<int> block_, place_in_block_;  // groups relaxed together; of each group its place in the block or -1
  // If there are couplings, all coupled groups are in the block: factors, potentials, and what the
  // others and the cells brought them when they were relaxed last.
  bool is_coupled_ = false;
  NetworkFactors block_factors_;
  std::vector<double> block_phi_, block_flux_;
  // Faces and absorbed groups as in Level.
  std::vector<float> east_, north_;
  std::vector<AbsorbedGroup> newly_absorbed_;
  std::vector<std::int32_t> covered_cell_;  // by body
  std::vector<int> covered_start_, body_group_;
  std::ptrdiff_t natural_stride_ = 0;
  std::vector<float> natural_;
};

}  // namespace lichtenberg::laplace
