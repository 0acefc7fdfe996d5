#pragma once

#include <cmath>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg {

/// A point or vector of the plane (metres, unless said otherwise).
struct Vec2 {
  double x = 0, y = 0;

  LICHTENBERG_HOST_DEVICE constexpr Vec2& operator+=(Vec2 b) {
    x += b.x;
    y += b.y;
    return *this;
  }
  LICHTENBERG_HOST_DEVICE constexpr Vec2& operator-=(Vec2 b) {
    x -= b.x;
    y -= b.y;
    return *this;
  }
  LICHTENBERG_HOST_DEVICE constexpr Vec2& operator*=(double s) {
    x *= s;
    y *= s;
    return *this;
  }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator*(Vec2 a, double s) { return s * a; }
  LICHTENBERG_HOST_DEVICE friend constexpr Vec2 operator/(Vec2 a, double s) { return {a.x / s, a.y / s}; }
  friend constexpr bool operator==(Vec2 a, Vec2 b) = default;
};

LICHTENBERG_HOST_DEVICE constexpr double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
LICHTENBERG_HOST_DEVICE constexpr double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// a turned by +90 degrees.
LICHTENBERG_HOST_DEVICE constexpr Vec2 perpendicular(Vec2 a) { return {-a.y, a.x}; }
LICHTENBERG_HOST_DEVICE constexpr double norm2(Vec2 a) { return dot(a, a); }
LICHTENBERG_HOST_DEVICE inline double norm(Vec2 a) { return std::sqrt(norm2(a)); }

}  // namespace lichtenberg
