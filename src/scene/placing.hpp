#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Random numbers that are identical on every machine: the 64-bit Mersenne twister of the standard and an explicit
/// conversion. The standard prescribes the output of the twister, but not that of its distributions.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : engine_(seed) {}
  /// Returns a number uniform in [0, 1): the upper 53 bits of the next output, times 2^-53.
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (*this)() * (high - low); }

 private:
  std::mt19937_64 engine_;
};

/// A disk of a plane domain (centre with z = 0), or a sphere.
struct Sphere {
  Vec3 centre;        ///< m
  double radius = 0;  ///< m
};

inline Sphere sphere_of(const Conductor& conductor) { return {conductor.position, conductor.radius}; }

/// Cell list of disks or spheres, so that neighbours are found without testing all bodies. Along periodic axes,
/// distances are to the nearest image.
class SphereGrid {
 public:
  /// Makes an empty grid. `reach`: the largest centre distance (m) at which two bodies can conflict. `count`: expected
  /// number of bodies; the number of buckets is at most a few times as large.
  SphereGrid(double reach, std::size_t count, const Domain& domain);

  void insert(const Sphere& sphere);
  /// Returns the index, in the order of insertion, of a body closer than `clearance` (m) to `sphere`, surface to
  /// surface.
  std::optional<std::size_t> conflict(const Sphere& sphere, double clearance) const;
  const Sphere& operator[](std::size_t index) const { return spheres_[index]; }
  /// Surface-to-surface distance (m); negative if the bodies overlap.
  double gap(const Sphere& a, const Sphere& b) const { return distance(a.centre, b.centre) - b.radius - a.radius; }

 private:
  static constexpr int none = -1;
  /// Index of a coordinate's bucket along an axis. Coordinates outside the domain are in the last bucket on their side,
  /// or in that of their image.
  int bucket_along(int axis, double coordinate) const;
  /// Returns the index of the bucket `steps` further along the axis; `none` beyond a side.
  int neighbour_bucket(int axis, int bucket, int steps) const;
  std::optional<std::size_t> conflict_in(std::size_t bucket, const Sphere& sphere, double clearance) const;
  double distance(Vec3 a, Vec3 b) const;

  Box<3> box_;
  NearestImage<3> nearest_;
  std::array<int, 3> buckets_;  ///< along each axis
  std::vector<Sphere> spheres_;
  std::vector<int> latest_;  ///< last inserted body of each bucket, `none` if it is empty
  std::vector<int> before_;  ///< body inserted into the same bucket before this one
};

/// Tolerance for rounding of decimal numbers where disks touch, as a fraction of the radius.
constexpr double touching_slack = 1e-9;
/// Diameter of the smallest body, as a fraction of the domain's longest side.
constexpr double finest_diameter = 1e-9;

/// Throws InputError for individually given conductors that overlap each other, an electrode or a side of the domain.
/// Throws InputError for a centre beyond a periodic side and for a conductor that overlaps its own image. Touching is
/// allowed.
void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes);

/// Returns the individually given conductors, then the populations in the order of the file, with the positions and
/// radii of `bodies`. Throws InputError for an invalid population, if the numbers differ, or if a body has a radius
/// that the file does not give it.
std::vector<Conductor> conductors_at(const Draft& draft, const std::vector<Conductor>& bodies);

/// Returns the individually given conductors, then the populations in the order of the file. Each conductor of a
/// population takes its first free random position (random sequential addition). If overlaps are allowed, it only has
/// to be free of electrodes and walls. The generator draws the radius, if it is an interval, then x, y (and z) of each
/// try. Throws InputError for an invalid count, region or choice of radii of a population, or if a conductor finds no
/// position because the population is too dense. Throws Stopped if `stop` returns true, which is called for each
/// conductor and each millisecond.
std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls, const StopRequest& stop);

}  // namespace lichtenberg
