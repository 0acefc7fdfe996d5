#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::laplace {

/// Square lattice of potentials with red-black relaxation of Laplace's equation (Stephenson 2018, D 6.3). Sites are
/// at (i h, j h), i = 0 ... cells_x, j = 0 ... cells_y, with the spacing h.
/// Sites are stored by colour, red or black like a chessboard (D 6.5). Rows of a colour are contiguous, so that the
/// update of one colour is a loop over contiguous arrays. A frame of mirror sites around the box represents insulating
/// sides.
class Lattice {
 public:
  static constexpr int fluid = -1;  ///< Mark of a site outside all conductors, whose potential is relaxed

  /// Sets size, spacing (m), insulating sides (by SideIndex) and fixed sites. `fixed[j * (cells_x + 1) + i]` is `fluid`
  /// for a relaxed site, any other number for a site of fixed potential. Potentials are kept if the lattice has the
  /// same size as before, otherwise set to zero.
  void reset(int cells_x, int cells_y, double spacing, const std::array<bool, 4>& insulating,
             const std::vector<int>& fixed);

  int cells_x() const { return nx_ - 1; }            ///< Number of lattice spacings along x
  int cells_y() const { return ny_ - 1; }            ///< Number of lattice spacings along y
  double spacing() const { return h_; }              ///< Lattice spacing (m)
  long fluid_sites() const { return fluid_sites_; }  ///< Number of relaxed sites

  double& at(int i, int j) { return value_[slot(i, j)]; }  ///< Potential (V) at site (i, j)
  double at(int i, int j) const { return value_[slot(i, j)]; }

  /// Performs a number of sweeps of red-black successive over-relaxation (SOR) with the factor `omega` (Stephenson
  /// 2018, D 6.7).
  void relax(int sweeps, double omega);

  /// Computes the residual of Laplace's equation: the sum over relaxed sites of |4 V - sum of the neighbours| (V).
  /// Times the permittivity it is the sum of the magnitudes of the charges (C/m) that the unfinished relaxation leaves
  /// outside the conductors. It bounds the charge that further relaxation can still move onto conductors.
  double leftover() const;

  /// Computes the potential's gradient (V/m) at p (m) by bilinear interpolation between the four sites around p
  /// (Stephenson 2018, D 6.10 and 6.13, corrected). On an insulating side its normal component is zero.
  Vec2 gradient(Vec2 p) const;

  /// Computes the Dirichlet integral of |grad V|^2 over the box (V^2), from the differences along the lattice's edges.
  /// Times eps / 2 it is the field energy (J/m).
  double dirichlet_integral() const;

  /// Computes the integral over one side (SideIndex) of the potential's normal derivative out of the box (V). Times the
  /// permittivity it is the side's charge (C/m). Sites in corners have half the weight.
  double flux_through(int side) const;

 private:
  /// Run of consecutive relaxed sites of one colour in one row. A slot is an index in value_.
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
