#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <unordered_map>
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

/// Disks or spheres in square or cubic buckets, so that the neighbours of one are found without looking at all of them.
/// Along periodic axes of the domain the nearest images count.
class SphereGrid {
 public:
  /// `reach`: the largest centre distance (m) at which two can matter to each other.
  SphereGrid(double reach, const Domain& domain)
      : side_(reach), box_(domain.box()), layers_(domain.dimension() == 3 ? 1 : 0) {}

  /// Along periodic axes the centre must be in the domain.
  void insert(const Sphere& sphere);
  /// Index, in the order of insertion, of one closer than `clearance` to this one, surface to surface.
  std::optional<std::size_t> conflict(const Sphere& sphere, double clearance) const;
  const Sphere& operator[](std::size_t index) const { return spheres_[index]; }
  /// m, from surface to surface; negative if they overlap.
  double gap(const Sphere& a, const Sphere& b) const {
    return norm(box_.difference(a.centre, b.centre)) - b.radius - a.radius;
  }

 private:
  struct Bucket {
    std::int64_t x, y, z;
    bool operator==(const Bucket&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Bucket& bucket) const;
  };
  Bucket bucket_of(Vec3 p) const;
  std::optional<std::size_t> conflict_near(Vec3 place, const Sphere& sphere, double clearance) const;

  double side_;
  Box<3> box_;
  int layers_;  ///< of buckets to look at on either side along z
  std::vector<Sphere> spheres_;
  std::unordered_map<Bucket, std::vector<std::size_t>, Hash> buckets_;
};

/// Rounding of decimal numbers allowed where disks touch, as a fraction of the radius.
constexpr double touching_slack = 1e-9;

/// Refuses conductors, given one by one, that overlap each other, an electrode or a side of the domain, or whose centre
/// is beyond a periodic side. Touching is allowed.
void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes);

/// The conductors given one by one, and after them the populations in the order of the file, each conductor at the
/// first of its random places that is free (random sequential addition; where overlaps are allowed, free of electrodes
/// and walls). Per conductor the generator is asked for the radius, if that is an interval, then for x, y (and z) of
/// each try. Throws InputError if a conductor finds no place: the population is too dense.
std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls);

}  // namespace lichtenberg
