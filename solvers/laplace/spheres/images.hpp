#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "solvers/laplace/spheres/spheres.hpp"

namespace lichtenberg::laplace::spheres {

/// Reflects a vector: returns r with the opposite sign of the components along the axes of `mask` (bits x, y, z).
inline Vec3 mirrored(Vec3 r, int mask) { return {mask & 1 ? -r.x : r.x, mask & 2 ? -r.y : r.y, mask & 4 ? -r.z : r.z}; }

/// Image charge of a charge at position c: `sign` times the charge, at the position mirrored(c, mask) + shift.
struct MirrorImage {
  int mask = 0;
  Vec3 shift;
  double sign = 1;

  friend bool operator==(const MirrorImage&, const MirrorImage&) = default;
};

/// Method of images for the sides of the box: an insulating side reflects a charge to an image of equal sign, an
/// electrode at 0 V to an image of opposite sign. Repeated reflections between two sides of one kind, at a distance L,
/// make images with a period of 2 L. Between sides of different kinds the period is 4 L. A periodic axis has its own
/// length as the period. Free space has no mirrors.
struct Mirrors {
  /// Finds the images for the box of a problem, or the charge itself only in free space.
  explicit Mirrors(const SphereProblem& problem);

  bool bounded = false;              ///< False in free space
  Vec3 period;                       ///< Period of all images along each axis (m)
  std::vector<MirrorImage> images;   ///< Images in one period, the charge itself first
  std::array<bool, 3> alternates{};  ///< Axes along which half a period changes the sign

  friend bool operator==(const Mirrors&, const Mirrors&) = default;
  /// Returns the volume (m^3) of one period of all images.
  double volume() const { return period.x * period.y * period.z; }
  /// Returns the number of images of one charge per volume (1/m^3).
  double density() const { return static_cast<double>(images.size()) / volume(); }
  /// Calls visit(displacement) for every periodic copy of the point `first` closer than `range` (m) to p, with the
  /// displacement from the copy to p. In free space the only copy is `first` itself, at any distance.
  template <class Visit>
  void for_each_copy(Vec3 p, Vec3 first, double range, Visit visit) const;
  /// Calls visit(image, displacement) for every image of a charge at c closer than `range` (m) to p, with the
  /// displacement from the image to p. The charge itself counts as an image; in free space it is the only one, at any
  /// distance.
  template <class Visit>
  void for_each_near(Vec3 p, Vec3 c, double range, Visit visit) const {
    for (const MirrorImage& image : images)
      for_each_copy(p, mirrored(c, image.mask) + image.shift, range,
                    [&](Vec3 displacement) { visit(image, displacement); });
  }
};

template <class Visit>
void Mirrors::for_each_copy(Vec3 p, Vec3 first, double range, Visit visit) const {
  if (!bounded) return visit(p - first);
  std::array<int, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = static_cast<int>(std::ceil((p[k] - range - first[k]) / period[k]));
    high[k] = static_cast<int>(std::floor((p[k] + range - first[k]) / period[k]));
  }
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int z = low[2]; z <= high[2]; ++z) {
        const Vec3 displacement = p - (first + Vec3{x * period.x, y * period.y, z * period.z});
        if (norm2(displacement) < range * range) visit(displacement);
      }
}

}  // namespace lichtenberg::laplace::spheres
