#pragma once

#include <cmath>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// Source of a field: a disk with its charge and multipoles, or a point charge inside a disk.
struct Source {
  Complex centre;
  double radius = 0;  ///< Radius of a disk (m), the unit of its multipole coefficients
  int order = 0;      ///< Highest multipole
  /// Centres of the circles on which its potential is constant (for a point charge: together with its partner's). For a
  /// disk this is its own circle, for a point charge the two circles of its close pair.
  std::array<Complex, 2> constant_on;
};

/// Grid of nearly square cells. Sources in near cells act on each other directly, sources in far cells cell by cell.
/// Mirror images continue the grid: cell (i, j) with any integers is an image of a cell of the box.
class Cells {
 public:
  Cells(const Mirrors& mirrors, const std::vector<Source>& disks);
  /// Adds a point charge inside a disk to the grid.
  void add(int index, const Source& point) { members_[cell_of(point.centre)].push_back(index); }

  int nx = 1, ny = 1;
  Complex origin;                ///< Lower left corner of the grid
  double width = 0, height = 0;  ///< Width and height of a cell
  int window = 1;                ///< Cells at most this many rows and columns apart are near
  double separation = 0;         ///< Largest extent of a cell's sources from its centre, over the least distance of a
                                 ///< far disk from that centre

  Complex centre(int i, int j) const { return origin + Complex{(i + 0.5) * width, (j + 0.5) * height}; }
  Complex centre(int cell) const { return centre(cell % nx, cell / nx); }
  int cell_of(Complex z) const;
  bool contains(Complex z) const;
  const std::vector<int>& members(int cell) const { return members_[cell]; }
  bool is_near(int i, int j) const { return std::abs(i) <= window && std::abs(j) <= window; }

  /// Calls visit(source, image, shift) for each source, or image of a source, in the cells near that of z. The image
  /// maps the source's centre to `image.centre(c) + shift`.
  template <class Visit>
  void for_each_near(Complex z, Visit visit) const;

 private:
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
