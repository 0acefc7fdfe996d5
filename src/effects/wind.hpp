#pragma once

#include <cmath>
#include <cstdint>

#include "solvers/geometry/host_device.hpp"
#include "solvers/random.hpp"

namespace lichtenberg::effects {

/// Exact time integration of the drag of a gas with random velocities (GasDrag) for one grain, on the CPU and on a
/// device. Reduced units.
struct Wind {
  double stokes = 0;            ///< drag coefficient S (1/t0)
  double speed = 0;             ///< standard deviation of each component of the gas velocity (v0)
  double correlation_time = 1;  ///< time after which the gas velocity is redrawn (t0)
  std::uint64_t seed = 0;       ///< seed of the random numbers

  /// Changes the momentum [d] of grain i from `time` to `time` + dt, with dv/dt = S (v_gas - v). `mass`: its mass; d:
  /// dimension. The gas velocity depends only on the seed, the grain and the interval of time.
  LICHTENBERG_HOST_DEVICE void operator()(double time, double dt, int i, double mass, double* momentum, int d) const {
    const double end = time + dt;
    while (time < end) {
      auto interval = static_cast<std::uint64_t>(time / correlation_time);
      double next = static_cast<double>(interval + 1) * correlation_time;
      if (next <= time) next = static_cast<double>(++interval + 1) * correlation_time;  // rounding
      if (next > end) next = end;
      blow(next - time, interval, i, mass, momentum, d);
      time = next;
    }
  }

 private:
  /// Changes the momentum [d] of grain i during a time dt at constant gas velocity. `interval`: index of the period of
  /// constant gas velocity that contains dt.
  LICHTENBERG_HOST_DEVICE void blow(double dt, std::uint64_t interval, int i, double mass, double* momentum,
                                    int d) const {
    const double kept = std::exp(-stokes * dt);
    Random random({seed, RandomPurpose::gas, static_cast<std::uint64_t>(i), 0, interval});
    for (int k = 0; k < d; ++k) {
      const double gas = speed > 0 ? speed * random.normal() * mass : 0;
      momentum[k] = gas + (momentum[k] - gas) * kept;
    }
  }
};

}  // namespace lichtenberg::effects
