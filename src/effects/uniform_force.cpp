#include "src/effects/uniform_force.hpp"

#include "src/effects/device_forces.hpp"
#include "src/effects/vector_key.hpp"
#include "src/model/drive_part.hpp"

namespace lichtenberg::effects {

const EffectKind& UniformForceOptions::kind() {
  static const EffectKind kind = {
      .name = "uniform_force",
      .description = "the same acceleration of every grain",
      .help =
          "A uniform force, such as gravity, accelerates all grains equally in any direction. In a periodic box "
          "contacts "
          "do not limit their common velocity; gas_drag does.",
      .options = UniformForceOptions{},
      .keys = {{.name = "acceleration",
                .target = target<&UniformForceOptions::acceleration>,
                .unit = "d0/t0^2",
                .required = true,
                .help = "acceleration of every grain, in reduced units (d0/t0^2): a vector with one component per "
                        "dimension of the domain"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check =
          [](const Draft& draft) {
            check_components(draft, "effects.uniform_force.acceleration",
                             draft.scene.effects.find<UniformForceOptions>()->acceleration);
          },
      .make =
          [](const Scene& scene) { return std::make_unique<UniformForce>(*scene.effects.find<UniformForceOptions>()); },
      .device =
          [](const Scene& scene, DeviceForces& forces) {
            const Vec3 acceleration = scene.effects.find<UniformForceOptions>()->acceleration.value;
            forces.drives.push_back(drive_form_with_kernels(UniformImpulse{acceleration}));
          }};
  return kind;
}

std::optional<double> UniformForce::drive(double, double dt, Bodies& bodies) {
  const int d = bodies.dimension;
  double work = 0;
  for (int i = 0; i < bodies.size(); ++i)
    for (int k = 0; k < d; ++k) {
      double& momentum = bodies.momentum[i * d + k];
      const double impulse = impulse_.impulse(dt, bodies.mass[i], k);
      work += impulse * (momentum + 0.5 * impulse) / bodies.mass[i];
      momentum += impulse;
    }
  return work;
}

}  // namespace lichtenberg::effects
