#pragma once

#include <cmath>
#include <cstdint>

#include "solvers/geometry/host_device.hpp"
#include "solvers/random.hpp"

namespace lichtenberg::effects {

/// Exact action of GasDrag on a grain, on the CPU and on a device.
struct Wind {
  double stokes = 0;            ///< S
  double speed = 0;             ///< standard deviation of a component
  double correlation_time = 1;  ///< correlation time, after which the velocity is redrawn
  std::uint64_t seed = 0;

  /// Changes the momentum [d] of grain `i` with this mass from `time` to `time` + dt.
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
