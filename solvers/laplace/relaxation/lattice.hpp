#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Potential on the sites (i h, j h), i = 0 ... cells_x, j = 0 ... cells_y, and its relaxation (D 6.3).
/// Sites are stored by colour (D 6.5), with contiguous rows of each colour, so that the update of one colour is a loop
/// over four streams. One row and column of mirror sites surrounds the box.
class Lattice {
 public:
  static constexpr int fluid = -1;

  /// Sets the lattice. `fixed[j * (cells_x + 1) + i]` is `fluid` for a site to be relaxed and anything else for a fixed
  /// one; `insulating` by SideIndex. Potentials are kept if the lattice has the same size as before, otherwise they are
  /// zero.
  void reset(int cells_x, int cells_y, double spacing, const std::array<bool, 4>& insulating,
             const std::vector<int>& fixed);

  int cells_x() const { return nx_ - 1; }
  int cells_y() const { return ny_ - 1; }
  double spacing() const { return h_; }
  long fluid_sites() const { return fluid_sites_; }

  double& at(int i, int j) { return value_[slot(i, j)]; }
  double at(int i, int j) const { return value_[slot(i, j)]; }

  /// Performs red-black successive over-relaxation with factor `omega` (D 6.7).
  void relax(int sweeps, double omega);

  /// Returns the sum over the fluid of |4 V - sum of the neighbours|. Times the permittivity it is the charge (C/m)
  /// left in the fluid by the unfinished relaxation. It bounds the charge that further relaxation can still move onto
  /// conductors.
  double leftover() const;

  /// Returns the gradient (V/m) of the bilinear interpolation (D 6.10, 6.13, corrected). Site differences over the
  /// spacing are weighted by the distances from the site in cells, all four terms with the sign of a difference
  /// quotient. Across an insulating side it is zero on that side.
  Vec2 gradient(Vec2 p) const;

  /// Returns the integral of |grad V|^2 over the box (V^2), from the differences along the lattice's edges.
  double dirichlet_integral() const;

  /// Returns the integral of the normal derivative (out of the box) over one side (V); each half of a corner's cell
  /// counts.
  double flux_through(int side) const;

 private:
  /// Consecutive relaxed sites of one colour in one row.
  struct Run {
    std::ptrdiff_t own;   ///< Slot of the first site
    std::ptrdiff_t left;  ///< Slot of its left neighbour; right neighbours are one slot further
    std::ptrdiff_t count;
  };

  std::ptrdiff_t slot(int i, int j) const { return ((i + j) & 1) * colour_size_ + (j + 1) * stride_ + ((i + 1) >> 1); }
  void find_runs(const std::vector<int>& fixed);
  void relax_row(int colour, int j, double omega);
  void mirror_row(int colour, int j);
  void mirror_all();

  int nx_ = 0, ny_ = 0;  ///< Numbers of sites
  double h_ = 0;
  std::ptrdiff_t stride_ = 0, colour_size_ = 0;
  std::array<bool, 4> insulating_{};
  std::vector<double> value_;
  std::vector<Run> runs_;
  std::array<std::vector<std::size_t>, 2> first_run_;  ///< By colour and row: index of its first run, and a final end
  long fluid_sites_ = 0;
};

}  // namespace lichtenberg::laplace
