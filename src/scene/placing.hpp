#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Random numbers that are the same on every machine: the 64-bit Mersenne twister of the standard (its output is
/// prescribed, that of the standard's distributions is not) and an explicit conversion.
class UniformRandom {
 public:
  explicit UniformRandom(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in [0, 1): the upper 53 bits of the next output, times 2^-53.
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (*this)() * (high - low); }

 private:
  std::mt19937_64 engine_;
};

/// A disk of a plane domain, whose z is 0, or a sphere.
struct Sphere {
  Vec3 centre;        ///< m
  double radius = 0;  ///< m
};

inline Sphere sphere_of(const Conductor& conductor) { return {conductor.position, conductor.radius}; }

/// Disks or spheres in buckets that divide the domain, so that the neighbours of one are found without looking at all
/// of them. Along periodic axes the nearest images count.
class SphereGrid {
 public:
  /// `reach`: the largest centre distance (m) at which two can matter to each other. `count`: about how many it will
  /// hold; buckets are at most some times as many.
  SphereGrid(double reach, std::size_t count, const Domain& domain);

  void insert(const Sphere& sphere);
  /// Index, in the order of insertion, of one closer than `clearance` to this one, surface to surface.
  std::optional<std::size_t> conflict(const Sphere& sphere, double clearance) const;
  const Sphere& operator[](std::size_t index) const { return spheres_[index]; }
  /// m, from surface to surface; negative if they overlap.
  double gap(const Sphere& a, const Sphere& b) const { return distance(a.centre, b.centre) - b.radius - a.radius; }

 private:
  static constexpr int none = -1;
  /// Along an axis, of a place; one outside is in the last on its side, or where its image is.
  int bucket_along(int axis, double place) const;
  /// Of the one so many further along; none beyond a side.
  int bucket_beside(int axis, int bucket, int steps) const;
  std::optional<std::size_t> conflict_in(std::size_t bucket, const Sphere& sphere, double clearance) const;
  double distance(Vec3 a, Vec3 b) const;

  Box<3> box_;
  NearestImage<3> nearest_;
  std::array<int, 3> buckets_;  ///< along each axis
  std::vector<Sphere> spheres_;
  std::vector<int> latest_;  ///< of a bucket's, `none` if it is empty
  std::vector<int> before_;  ///< the one that came into its bucket before this one
};

/// Rounding of decimal numbers allowed where disks touch, as a fraction of the radius.
constexpr double touching_slack = 1e-9;
/// Of the smallest body, as a fraction of the domain's longest side.
constexpr double finest_diameter = 1e-9;

/// Refuses conductors, given one by one, that overlap each other, an electrode or a side of the domain, or whose centre
/// is beyond a periodic side. Touching is allowed.
void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes);

/// The conductors given one by one, and after them the populations in the order of the file, with the places and radii
/// of these bodies. Throws InputError if there are not as many, or one has a radius that the file does not give it.
std::vector<Conductor> conductors_at(const Draft& draft, const std::vector<Conductor>& bodies);

/// The conductors given one by one, and after them the populations in the order of the file, each conductor at the
/// first of its random places that is free (random sequential addition; where overlaps are allowed, free of electrodes
/// and walls). Per conductor the generator is asked for the radius, if that is an interval, then for x, y (and z) of
/// each try. Throws InputError if a conductor finds no place: the population is too dense; Stopped if `stop` says so,
/// which is asked for each conductor and each millisecond.
std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls, const StopRequest& stop);

}  // namespace lichtenberg
