#pragma once

#include <cmath>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// Cartesian vector or point of the plane (d = 2: x, y) or of space (d = 3: x, y, z); in metres unless stated
/// otherwise.
template <int d>
struct Vec;

template <>
struct Vec<2> {
  double x = 0, y = 0;

  LICHTENBERG_HOST_DEVICE constexpr double& operator[](int k) { return k == 0 ? x : y; }
  LICHTENBERG_HOST_DEVICE constexpr double operator[](int k) const { return k == 0 ? x : y; }
  friend constexpr bool operator==(Vec a, Vec b) = default;
};

template <>
struct Vec<3> {
  double x = 0, y = 0, z = 0;

  LICHTENBERG_HOST_DEVICE constexpr double& operator[](int k) { return k == 0 ? x : k == 1 ? y : z; }
  LICHTENBERG_HOST_DEVICE constexpr double operator[](int k) const { return k == 0 ? x : k == 1 ? y : z; }
  friend constexpr bool operator==(Vec a, Vec b) = default;
};

using Vec2 = Vec<2>;
using Vec3 = Vec<3>;

/// Projects a vector of space onto the xy plane: returns (x, y).
LICHTENBERG_HOST_DEVICE constexpr Vec2 plane(Vec3 a) { return {a.x, a.y}; }
/// Embeds a vector of the plane in space: returns (x, y, 0).
LICHTENBERG_HOST_DEVICE constexpr Vec3 in_space(Vec2 a) { return {a.x, a.y, 0}; }

template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d>& operator+=(Vec<d>& a, Vec<d> b) {
  a.x += b.x;
  a.y += b.y;
  if constexpr (d == 3) a.z += b.z;
  return a;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d>& operator-=(Vec<d>& a, Vec<d> b) {
  a.x -= b.x;
  a.y -= b.y;
  if constexpr (d == 3) a.z -= b.z;
  return a;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d>& operator*=(Vec<d>& a, double s) {
  a.x *= s;
  a.y *= s;
  if constexpr (d == 3) a.z *= s;
  return a;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator+(Vec<d> a, Vec<d> b) {
  return a += b;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator-(Vec<d> a, Vec<d> b) {
  return a -= b;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator*(Vec<d> a, double s) {
  return a *= s;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator*(double s, Vec<d> a) {
  return a *= s;
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator-(Vec<d> a) {
  if constexpr (d == 2)
    return {-a.x, -a.y};
  else
    return {-a.x, -a.y, -a.z};
}
template <int d>
LICHTENBERG_HOST_DEVICE constexpr Vec<d> operator/(Vec<d> a, double s) {
  if constexpr (d == 2)
    return {a.x / s, a.y / s};
  else
    return {a.x / s, a.y / s, a.z / s};
}

/// Returns the scalar product of a and b.
template <int d>
LICHTENBERG_HOST_DEVICE constexpr double dot(Vec<d> a, Vec<d> b) {
  if constexpr (d == 2)
    return a.x * b.x + a.y * b.y;
  else
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// Returns the squared length of a.
template <int d>
LICHTENBERG_HOST_DEVICE constexpr double norm2(Vec<d> a) {
  return dot(a, a);
}
/// Returns the length (Euclidean norm) of a.
template <int d>
LICHTENBERG_HOST_DEVICE inline double norm(Vec<d> a) {
  return std::sqrt(norm2(a));
}

/// Returns the z component of the cross product a x b of two vectors of the plane.
LICHTENBERG_HOST_DEVICE constexpr double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// Returns the cross product a x b.
LICHTENBERG_HOST_DEVICE constexpr Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Returns a rotated by +90 degrees (anticlockwise).
LICHTENBERG_HOST_DEVICE constexpr Vec2 perpendicular(Vec2 a) { return {-a.y, a.x}; }

}  // namespace lichtenberg
