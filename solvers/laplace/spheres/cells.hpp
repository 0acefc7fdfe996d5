#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Cell grid of the fast multipole method: divides the box or, in free space, a cuboid around all spheres. Mirrors and
/// periods continue the grid: a cell (x, y, z) outside is the image of a cell inside. Two cells are near each other if
/// the distance of their centres is below `range`; near spheres interact directly, far cells by multipoles.
struct Cells {
  /// Makes a grid with about one sphere per cell (more if spheres are large), and sorts the spheres (`sources`) into
  /// the cells.
  Cells(const SphereProblem& problem, const std::vector<Site>& sources);

  std::array<int, 3> count{1, 1, 1};  ///< Number of cells along each axis
  Vec3 origin, edge;                  ///< Lower corner of the grid, and edges of a cell (m)
  /// Number of cells along each axis after which all images repeat. In free space, without images, twice `count`.
  std::array<int, 3> period{};
  std::array<bool, 3> mirrored{};         ///< Axes with mirrors
  double reach = 0;                       ///< Largest distance of a charge from its cell's centre (m)
  double range = 0;                       ///< Distance of cell centres below which cells are near (m)
  std::vector<std::vector<int>> members;  ///< Spheres in each cell

  int cells() const { return count[0] * count[1] * count[2]; }  ///< Total number of cells
  /// Returns the indices (x, y, z) of the cell that contains p, or of the nearest cell if p is outside.
  std::array<int, 3> indices(Vec3 p) const;
  /// Returns the centre (m) of the cell with these indices.
  Vec3 centre(std::array<int, 3> at) const {
    return origin + Vec3{(at[0] + 0.5) * edge.x, (at[1] + 0.5) * edge.y, (at[2] + 0.5) * edge.z};
  }
  /// Returns the number of the cell with these indices, z fastest.
  int number(std::array<int, 3> at) const { return (at[0] * count[1] + at[1]) * count[2] + at[2]; }
  /// Returns the displacement (m) between cells that are x, y and z cells apart along the axes.
  Vec3 displacement(int x, int y, int z) const { return {x * edge.x, y * edge.y, z * edge.z}; }
  /// Returns true if cells that are x, y and z cells apart along the axes are near each other.
  bool is_near(int x, int y, int z) const { return norm2(displacement(x, y, z)) < range * range; }

  double low_sign(int axis) const { return side_sign_[2 * axis]; }  ///< Sign of images at the low side

  /// Finds all pairs of a target and a source, or an image of a source, in near cells, except a sphere with itself;
  /// sorted by target. `sources` must be the spheres of the grid.
  std::vector<NearPair> near_pairs(const std::vector<Site>& targets, const std::vector<Site>& sources,
                                   parallel::Team& team) const;

 private:
  /// Cell inside the grid that a cell mirrors or repeats, along one axis, and the reflection and shift (m) between
  /// them.
  struct ImageCell {
    int index = -1;  ///< Index of the cell inside, -1 if there is none
    bool reflected = false;
    double shift = 0, sign = 1;
  };
  ImageCell inside(int axis, int index) const;
  /// Cells of a target's neighbourhood: their offsets, and the cells inside for each index along each axis, from
  /// -`most` on.
  struct Neighbourhood {
    std::array<int, 3> most{};
    std::vector<std::array<int, 3>> offsets;
    std::array<std::vector<ImageCell>, 3> inside;
  };
  Neighbourhood neighbourhood() const;
  void add_near_pairs(int target, Vec3 position, const std::vector<Site>& sources, const Neighbourhood& near,
                      std::vector<NearPair>& pairs) const;

  bool bounded_ = false;
  Vec3 lengths_;
  std::array<double, 6> side_sign_{};
};

}  // namespace lichtenberg::laplace::spheres
