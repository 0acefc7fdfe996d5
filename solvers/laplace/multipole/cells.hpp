#pragma once

#include <cmath>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// Source of the electric field in the multipole method: a disk with a charge and multipoles at its centre, or a point
/// charge inside a disk.
struct Source {
  Complex centre;     ///< Position x + i y (m)
  double radius = 0;  ///< Radius (m), the unit of length of the multipole coefficients; 0 for a point charge
  int order = 0;      ///< Highest multipole order
  /// Centres of the circles on which its potential is constant (for a point charge: together with its partner's). For a
  /// disk this is its own circle, for a point charge the two circles of its close pair.
  std::array<Complex, 2> constant_on;
};

/// Cell grid of the fast multipole method: sources sorted into nearly square cells, about one disk per cell. Sources in
/// near cells act on each other directly (NearField), sources in far cells by expansions about the cells' centres
/// (FarField). Mirror images continue the grid: a cell (i, j) outside the box is the image of a cell inside.
class Cells {
 public:
  /// Makes the grid for the box, or for the bounding rectangle of the disks in the unbounded plane. Chooses the window
  /// of near cells such that multipoles of far cells converge.
  Cells(const Mirrors& mirrors, const std::vector<Source>& disks);
  /// Adds source number `index`, a point charge inside a disk, to the cell that contains it.
  void add(int index, const Source& point) { members_[cell_of(point.centre)].push_back(index); }

  int nx = 1, ny = 1;            ///< Numbers of cells along x and y
  Complex origin;                ///< Lower left corner of the grid (m)
  double width = 0, height = 0;  ///< Width and height of a cell (m)
  int window = 1;                ///< Cells at most this many rows and columns apart are near
  /// Ratio that limits the convergence of cell multipoles: largest extent of a cell's sources from its centre, over the
  /// smallest distance of a far disk from that centre.
  double separation = 0;

  /// Returns the centre (m) of the cell in column i and row j.
  Complex centre(int i, int j) const { return origin + Complex{(i + 0.5) * width, (j + 0.5) * height}; }
  /// Returns the centre (m) of a cell by its index j nx + i.
  Complex centre(int cell) const { return centre(cell % nx, cell / nx); }
  /// Returns the index of the cell that contains z, or of the nearest cell if z is outside the grid.
  int cell_of(Complex z) const;
  /// Returns true if z is inside the grid.
  bool contains(Complex z) const;
  /// Returns the indices of the sources in a cell.
  const std::vector<int>& members(int cell) const { return members_[cell]; }
  /// Returns true if two cells i columns and j rows apart are near each other, so that their sources interact directly.
  bool is_near(int i, int j) const { return std::abs(i) <= window && std::abs(j) <= window; }

  /// Calls visit(source, image, shift) for each source, or mirror image of a source, in the cells near the cell of z.
  /// `source`: index of the source. The source or image is at `image.centre(c) + shift`, where c is the centre of the
  /// source.
  template <class Visit>
  void for_each_near(Complex z, Visit visit) const;

 private:
  /// Cell of the box that a cell outside mirrors, along one axis, and the reflection that maps the first to the second.
  struct ImageCell {
    int index = -1;  ///< Index of the cell of the box, -1 if there is none
    bool flipped = false;
    double shift = 0, sign = 1;
  };
  ImageCell image_cell(int i, int n, double length, int sign_low, int period_sign) const;

  bool bounded_ = false;
  Vec2 size_;
  std::array<int, 4> side_sign_{};
  std::vector<std::vector<int>> members_;
};

template <class Visit>
void Cells::for_each_near(Complex z, Visit visit) const {
  const int cell = cell_of(z), i = cell % nx, j = cell / nx;
  for (int dj = -window; dj <= window; ++dj) {
    const ImageCell y = image_cell(j + dj, ny, size_.y, side_sign_[bottom], side_sign_[bottom] * side_sign_[top]);
    if (y.index < 0) continue;
    for (int di = -window; di <= window; ++di) {
      const ImageCell x = image_cell(i + di, nx, size_.x, side_sign_[left], side_sign_[left] * side_sign_[right]);
      if (x.index < 0) continue;
      const Image image{x.flipped, y.flipped, x.sign * y.sign};
      for (const int source : members_[y.index * nx + x.index]) visit(source, image, Complex{x.shift, y.shift});
    }
  }
}

}  // namespace lichtenberg::laplace::multipole
