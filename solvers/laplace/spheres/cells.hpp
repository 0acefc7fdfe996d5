#pragma once

#include <array>
#include <vector>

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Cells of the box or, in free space, around all spheres. Mirrors and periods continue the grid: cell (x, y, z) with
/// any integers is an image of a cell inside. Two cells are near each other if the distance of their centres is below
/// `range`.
struct Cells {
  /// Makes cells with about one sphere each.
  Cells(const SphereProblem& problem, const std::vector<Site>& sources);

  std::array<int, 3> count{1, 1, 1};
  Vec3 origin, edge;
  std::array<int, 3> period{};     ///< Number of cells after which all images repeat; in free space twice the cells,
                                   ///< without images
  std::array<bool, 3> mirrored{};  ///< Axes with mirrors
  double reach = 0;                ///< Largest distance of a charge from its cell's centre
  double range = 0;                ///< Distance of cell centres below which cells are near
  std::vector<std::vector<int>> members;

  int cells() const { return count[0] * count[1] * count[2]; }
  std::array<int, 3> indices(Vec3 p) const;
  Vec3 centre(std::array<int, 3> at) const {
    return origin + Vec3{(at[0] + 0.5) * edge.x, (at[1] + 0.5) * edge.y, (at[2] + 0.5) * edge.z};
  }
  int number(std::array<int, 3> at) const { return (at[0] * count[1] + at[1]) * count[2] + at[2]; }
  Vec3 displacement(int x, int y, int z) const { return {x * edge.x, y * edge.y, z * edge.z}; }
  bool is_near(int x, int y, int z) const { return norm2(displacement(x, y, z)) < range * range; }

  double low_sign(int axis) const { return side_sign_[2 * axis]; }  ///< Sign of images at the low side

  /// Returns all sources, and images of sources, in cells near the targets.
  std::vector<NearPair> near_pairs(const std::vector<Site>& targets, const std::vector<Site>& sources) const;

 private:
  struct ImageCell {
    int index = -1;  ///< Index of the cell inside, -1 if there is none
    bool reflected = false;
    double shift = 0, sign = 1;
  };
  ImageCell inside(int axis, int index) const;

  bool bounded_ = false;
  Vec3 lengths_;
  std::array<double, 6> side_sign_{};
};

}  // namespace lichtenberg::laplace::spheres
