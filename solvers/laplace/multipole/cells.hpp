#pragma once

#include <cmath>

#include "solvers/laplace/multipole/mirrors.hpp"

namespace lichtenberg::laplace::multipole {

/// What a field comes from: a disk with its charge and multipoles, or a point charge inside one.
struct Source {
  Complex centre;
  double radius = 0;  ///< m, of a disk; coefficients are in powers of it
  int order = 0;      ///< highest multipole
  /// Centres of the circles on which its field (with its partner's, for a point charge) is constant: a disk's own
  /// circle, or the two circles of a close pair.
  std::array<Complex, 2> constant_on;
};

/// Square-like cells that sort the sources into near ones, which act on each other one by one, and far ones, which act
/// cell on cell. The mirrors continue the grid: cell (i, j) with any integers is an image of one inside.
class Cells {
 public:
  Cells(const Mirrors& mirrors, const std::vector<Source>& disks);
  /// Sorts a point charge that is inside a disk into the grid.
  void add(int index, const Source& point) { members_[cell_of(point.centre)].push_back(index); }

  int nx = 1, ny = 1;
  Complex origin;                ///< of the grid's lower left corner
  double width = 0, height = 0;  ///< of a cell
  int window = 1;                ///< cells as many rows and columns apart are still near
  double separation = 0;         ///< reach of a source from its cell's centre over its distance from a far disk

  Complex centre(int i, int j) const { return origin + Complex{(i + 0.5) * width, (j + 0.5) * height}; }
  Complex centre(int cell) const { return centre(cell % nx, cell / nx); }
  int cell_of(Complex z) const;
  bool contains(Complex z) const;
  const std::vector<int>& members(int cell) const { return members_[cell]; }
  bool is_near(int i, int j) const { return std::abs(i) <= window && std::abs(j) <= window; }

  /// Calls visit(source, image) for every source and image of one whose cell is near the cell of z; the image maps the
  /// source's centre to `image.centre(c) + shift`.
  template <class Visit>
  void for_each_near(Complex z, Visit visit) const;

 private:
  struct Place {
    int index = -1;  ///< of the cell inside, -1 if there is none
    bool flipped = false;
    double shift = 0, sign = 1;
  };
  Place place(int i, int n, double length, int sign_low, int period_sign) const;

  bool bounded_ = false;
  Vec2 size_;
  std::array<int, 4> side_sign_{};
  std::vector<std::vector<int>> members_;
};

template <class Visit>
void Cells::for_each_near(Complex z, Visit visit) const {
  const int cell = cell_of(z), i = cell % nx, j = cell / nx;
  for (int dj = -window; dj <= window; ++dj) {
    const Place y = place(j + dj, ny, size_.y, side_sign_[bottom], side_sign_[bottom] * side_sign_[top]);
    if (y.index < 0) continue;
    for (int di = -window; di <= window; ++di) {
      const Place x = place(i + di, nx, size_.x, side_sign_[left], side_sign_[left] * side_sign_[right]);
      if (x.index < 0) continue;
      const Image image{x.flipped, y.flipped, x.sign * y.sign};
      for (const int source : members_[y.index * nx + x.index]) visit(source, image, Complex{x.shift, y.shift});
    }
  }
}

}  // namespace lichtenberg::laplace::multipole
