#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Uniform random numbers that are identical on every machine: the 64-bit Mersenne twister of the standard and an
/// explicit conversion. The standard prescribes the output of the twister, but not that of its distributions.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : engine_(seed) {}
  /// Returns a number uniform in [0, 1): the upper 53 bits of the twister's next output, times 2^-53.
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// Returns a number uniform between low and high.
  double between(double low, double high) { return low + (*this)() * (high - low); }

 private:
  std::mt19937_64 engine_;
};

/// A disk (centre with z = 0) of a plane domain, or a sphere.
struct Sphere {
  Vec3 centre;        ///< m
  double radius = 0;  ///< m
};

/// Returns the disk or sphere that a conductor fills.
inline Sphere sphere_of(const Conductor& conductor) { return {conductor.position, conductor.radius}; }

/// Cell list of disks or spheres for the search of overlaps, which does not test all bodies. Along periodic axes,
/// distances are to the nearest image.
class SphereGrid {
 public:
  /// Makes an empty cell list. `reach`: the largest centre distance (m) at which two bodies can conflict. `count`:
  /// expected number of bodies; the number of buckets (cells) is at most 64 + 8 * count.
  SphereGrid(double reach, std::size_t count, const Domain& domain);

  void insert(const Sphere& sphere);
  /// Finds a body closer than `clearance` (m) to `sphere`, surface to surface. Returns its index in the order of
  /// insertion; empty if there is none.
  std::optional<std::size_t> conflict(const Sphere& sphere, double clearance) const;
  const Sphere& operator[](std::size_t index) const { return spheres_[index]; }
  /// Returns the surface-to-surface distance (m); negative if the bodies overlap.
  double gap(const Sphere& a, const Sphere& b) const { return distance(a.centre, b.centre) - b.radius - a.radius; }

 private:
  static constexpr int none = -1;
  /// Returns the index of a coordinate's bucket along an axis. Coordinates outside the domain are in the last bucket on
  /// their side, or along a periodic axis in that of their image.
  int bucket_along(int axis, double coordinate) const;
  /// Returns the index of the bucket `steps` further along the axis; `none` beyond a side.
  int neighbour_bucket(int axis, int bucket, int steps) const;
  double distance(Vec3 a, Vec3 b) const;

  Box<3> box_;
  NearestImage<3> nearest_;
  std::array<int, 3> buckets_;  ///< along each axis
  std::vector<Sphere> spheres_;
  std::vector<int> latest_;  ///< last inserted body of each bucket, `none` if it is empty
  std::vector<int> before_;  ///< body inserted into the same bucket before this one
};

/// Largest overlap of bodies that still counts as touching, as a fraction of the radius (rounding of decimal numbers).
constexpr double touching_slack = 1e-9;
/// Smallest diameter that a body may have, as a fraction of the domain's longest side.
constexpr double finest_diameter = 1e-9;

/// Throws InputError for [[conductor]]s (bodies with given positions) that overlap each other, an electrode or a side
/// of the domain. Throws InputError for a centre beyond a periodic side and for a conductor that overlaps its own
/// image. Touching is allowed.
void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes);

/// Makes the conductors of a scene with the positions and radii of `bodies`, from a result. First come the
/// [[conductor]]s, then the populations in the order of the file. Throws InputError for an invalid population, if the
/// numbers of bodies differ, or if the file does not allow the radius of a body.
std::vector<Conductor> conductors_at(const Draft& draft, const std::vector<Conductor>& bodies);

/// Makes the conductors of a scene, those of populations at random positions (random sequential addition). First come
/// the [[conductor]]s, then the populations in the order of the file. Each conductor of a population takes its first
/// random position that is free of other bodies. If overlaps are allowed, the position only has to be free of
/// electrodes and walls. The generator draws the radius, if it is an interval, then x, y (and z) of each try. Throws
/// InputError for an invalid count, region or choice of radii. Throws InputError if no position is found for a
/// conductor. Throws Stopped if `stop` returns true, which is called once for each conductor and about every
/// millisecond of its search.
std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls, const StopRequest& stop);

}  // namespace lichtenberg
