#pragma once

#include <array>

#include "solvers/geometry/host_device.hpp"
#include "solvers/periodic/influence.hpp"

// Potential of a unit charge's own cloud at its position, as computed on a mesh. It varies with the position between
// mesh points; the two leading waves along each axis are subtracted.
namespace lichtenberg::periodic {

/// Self term of a charge on a mesh, along one axis (or several, by SIMD). It contains the deviation of its own cloud's
/// potential from the mean, half of the slope of this potential, and its curvature. The slope is halved because the
/// cloud moves with the charge.
template <class Number>
struct SelfTerm {
  Number potential, half_slope, curvature;
};

/// Computes the self term of a charge at s spacings from the middle between two mesh points. `cosine` and
/// `half_derivative`: cos(2 pi s), and half of its derivative with respect to s. `first` and `second`: amplitudes of
/// waves_from_middle() for this axis. `inverse_spacing`: 1 over the spacing of mesh points.
template <class Real, class Number>
LICHTENBERG_HOST_DEVICE SelfTerm<Number> self_term(const Number& cosine, const Number& half_derivative,
                                                   const Number& first, const Number& second,
                                                   const Number& inverse_spacing) {
  constexpr Real pi = static_cast<Real>(3.14159265358979324), minus_4_pi2 = -4 * pi * pi;
  const Number twice = 2 * cosine * cosine - 1;
  return {first * cosine + second * twice, half_derivative * (first + 4 * second * cosine) * inverse_spacing,
          minus_4_pi2 * (first * cosine + 4 * second * twice) * inverse_spacing * inverse_spacing};
}

/// Returns the amplitudes of the self potential (Influence::self_wave), [wave][axis], with the middle between two mesh
/// points as origin. A shift by half a spacing changes the sign of the first wave (n = 1), and so does the half-spacing
/// offset of windows of odd order.
inline std::array<std::array<double, 4>, 2> waves_from_middle(const Influence& influence, int order) {
  std::array<std::array<double, 4>, 2> waves{};
  for (int k = 0; k < 3; ++k) {
    waves[0][k] = influence.self_wave[k][0] * (order % 2 == 0 ? -1 : 1);
    waves[1][k] = influence.self_wave[k][1];
  }
  return waves;
}

}  // namespace lichtenberg::periodic
