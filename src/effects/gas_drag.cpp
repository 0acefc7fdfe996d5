#include "src/effects/gas_drag.hpp"

#include <fmt/format.h>

#include <limits>

#include "src/effects/device_forces.hpp"
#include "src/model/drive_part.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg::effects {
namespace {

/// Refuses a time that is shorter than the spacing of doubles at the end of the run: Wind could not count the
/// intervals.
void check_correlation_time(const Draft& draft) {
  const double shortest = draft.scene.stop.time * std::numeric_limits<double>::epsilon(),
               given = draft.scene.effects.find<GasDragOptions>()->correlation_time;
  if (given > shortest) return;
  refuse(
      draft.scene.path, draft.line("effects.gas_drag.correlation_time"),
      fmt::format("effects.gas_drag.correlation_time = {:g} is not allowed: it must be longer than {:.3g}, stop.time "
                  "times the relative accuracy of a double",
                  given, shortest));
}

}  // namespace

const EffectKind& GasDragOptions::kind() {
  static const EffectKind kind = {
      .name = "gas_drag",
      .description = "drag of a gas that blows at random",
      .help =
          "Acceleration S (v_gas - v) of grains of velocity v by the drag of a gas (Singh 2019, eq. 3.54). The gas "
          "velocity v_gas is random for each grain and constant for a time h = correlation_time, which determines the "
          "temperature together with the speed. Without collisions grains of mass m0 have the temperature speed^2 "
          "tanh(S h / 2) when v_gas is redrawn, and smaller by a fraction of up to S h / 2 at other times. Collisions "
          "deflect velocities from v_gas. If each grain has elastic collisions at a frequency omega, the temperature "
          "averaged over time is T = speed^2 S / l (1 - (1 - exp(-l h)) / (l h)). Here l = S + 2 omega / d in d "
          "dimensions. With inelastic collisions it is lower.",
      .options = GasDragOptions{},
      .keys = {{.name = "stokes",
                .target = target<&GasDragOptions::stokes>,
                .unit = "1/t0",
                .range = ranges::positive,
                .help = "drag coefficient S = 1/tau, with the relaxation time tau of a grain's velocity in a gas at "
                        "rest, in reduced units (1/t0)"},
               {.name = "speed",
                .target = target<&GasDragOptions::speed>,
                .unit = "v0",
                .range = ranges::not_negative,
                .help = "standard deviation of each component of the gas velocity v_gas, in reduced units (v0); 0: a "
                        "gas at rest"},
               {.name = "correlation_time",
                .target = target<&GasDragOptions::correlation_time>,
                .unit = "t0",
                .range = ranges::positive,
                .help = "time after which the random gas velocity v_gas of a grain is redrawn, in reduced units (t0)",
                .old_name = "hold"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check =
          [](const Draft& draft) {
            require_in_si(draft, "effects.gas_drag.stokes");
            if (draft.scene.effects.find<GasDragOptions>()->speed > 0)
              require_in_si(draft, "effects.gas_drag.correlation_time");
            check_correlation_time(draft);
          },
      .make =
          [](const Scene& scene) {
            return std::make_unique<GasDrag>(*scene.effects.find<GasDragOptions>(), scene.seed);
          },
      .device =
          [](const Scene& scene, DeviceForces& forces) {
            const auto& drag = *scene.effects.find<GasDragOptions>();
            forces.drives.push_back(
                drive_form_with_kernels(Wind{drag.stokes, drag.speed, drag.correlation_time, scene.seed}));
          }};
  return kind;
}

std::optional<double> GasDrag::drive(double time, double dt, Bodies& bodies) {
  const auto kinetic = [&] {
    double energy = 0;
    for (std::size_t k = 0; k < bodies.momentum.size(); ++k)
      energy += bodies.momentum[k] * bodies.momentum[k] / (2 * bodies.mass[k / bodies.dimension]);
    return energy;
  };
  const double before = kinetic();
  const int d = bodies.dimension;
  for (int i = 0; i < bodies.size(); ++i) wind_(time, dt, i, bodies.mass[i], &bodies.momentum[i * d], d);
  return kinetic() - before;
}

}  // namespace lichtenberg::effects
