#pragma once

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Flat walls at the sides of a box that are not periodic. Sides are numbered as in side_names. For the host and for a
/// device.
class RoughSides {
 public:
  RoughSides() = default;
  /// `walled`: false without walls.
  RoughSides(const Bodies& bodies, bool walled) : lengths_(bodies.box.lengths) {
    for (int side = 0; walled && side < 2 * bodies.dimension; ++side)
      if (!bodies.box.periodic(side / 2)) walls_[count_++] = side;
  }

  LICHTENBERG_HOST_DEVICE bool any() const { return count_ > 0; }
  LICHTENBERG_HOST_DEVICE int count() const { return count_; }
  /// Returns the side of the k-th wall.
  LICHTENBERG_HOST_DEVICE int side(int k) const { return walls_[k]; }
  /// Returns the gap (d0) between a grain and a side, negative for an overlap.
  LICHTENBERG_HOST_DEVICE double gap(Vec3 position, double radius, int side) const {
    const double x = position[side / 2];
    return (side % 2 == 0 ? x : lengths_[side / 2] - x) - radius;
  }
  /// Calls use(side, gap) for each wall.
  template <class Use>
  void visit(Vec3 position, double radius, const Use& use) const {
    for (int k = 0; k < count_; ++k) use(walls_[k], gap(position, radius, walls_[k]));
  }
  /// Returns the unit vector from the domain into the wall.
  LICHTENBERG_HOST_DEVICE static Vec3 normal(int side) {
    Vec3 n;
    n[side / 2] = side % 2 == 0 ? -1 : 1;
    return n;
  }

 private:
  Vec3 lengths_;
  int walls_[6] = {}, count_ = 0;
};

}  // namespace lichtenberg::granular
