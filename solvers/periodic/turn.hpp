#pragma once

#include <array>
#include <cmath>

#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/lanes.hpp"

// The waves of what a charge sees of its own cloud by windows.
namespace lichtenberg::periodic {

/// cos(2 pi s), and its derivative by s^2, by their Taylor series, of four numbers: off by 2e-7 (single precision:
/// 2e-3) at the mesh's points, half a spacing from the middle, of an effect that is itself an error of the mesh.
template <class Real = double>
struct Turn {
  using Four = Lanes<4, Real>;
  Four cosine{}, slope{};

  explicit Turn(const Four& s) {
    const Four s2 = s * s;
    for (int term = terms - 1; term >= 0; --term) {
      slope = slope * s2 + cosine;
      cosine = cosine * s2 + series[term];
    }
  }
  Four twice() const { return 2 * cosine * cosine - 1; }

 private:
  static constexpr int terms = sizeof(Real) == sizeof(double) ? 9 : 7;
  /// In powers of s^2.
  static constexpr std::array<Real, terms> series = [] {
    std::array<Real, terms> of{};
    double term = 1;
    for (int k = 0; k < terms; term *= -4 * M_PI * M_PI / ((2 * k + 2) * (2 * k + 1)), ++k)
      of[k] = static_cast<Real>(term);
    return of;
  }();
};

/// Influence::self_wave as seen from the middle between two points, by wave and axis. Half a spacing turns the first
/// wave round; so does the mesh's lying back by half of an odd order.
inline std::array<std::array<double, 4>, 2> waves_from_middle(const Influence& influence, int order) {
  std::array<std::array<double, 4>, 2> waves{};
  for (int k = 0; k < 3; ++k) {
    waves[0][k] = influence.self_wave[k][0] * (order % 2 == 0 ? -1 : 1);
    waves[1][k] = influence.self_wave[k][1];
  }
  return waves;
}

}  // namespace lichtenberg::periodic
