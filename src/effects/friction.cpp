#include "src/effects/friction.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "solvers/random.hpp"
#include "src/effects/grain_contact_effect.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/effects/surface_effect.hpp"

namespace lichtenberg::effects {
namespace {

void check_friction(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<FrictionOptions>();
  if (!options.tangential_restitution) return;
  for (const char* key : {"stiffness_ratio", "damping_ratio"})
    refuse_if_given(draft, std::string("effects.friction.") + key,
                    "is given, and so is tangential_restitution, from which it follows: leave one of the two out");
  if (!draft.scene.effects.has<LinearContactOptions>())
    refuse(draft.scene.path, draft.line("effects.friction.tangential_restitution"),
           "effects.friction.tangential_restitution needs the table [effects.linear_contact], because the duration of "
           "other contacts depends on the speed: give stiffness_ratio instead");
}

/// Returns the ratio of tangential to normal stiffness for which a sticking contact of two grains of mass 1 ends with
/// tangential velocity -beta_0 times the initial one. Without tangential damping, the sticking surfaces oscillate with
/// the frequency w_t = sqrt(k_t (1 + 1/q) / m_eff) for the time t_c of the normal contact (q: `inertia`), so that
/// -beta_0 = cos(w_t t_c).
double ratio_for(double restitution, const LinearSpringLaw& law, double inertia) {
  constexpr double effective_mass = 0.5;
  const double frequency = std::acos(-restitution) / law.collision(effective_mass).duration;
  return frequency * frequency * effective_mass / (1 + 1 / inertia) / law.stiffness;
}

FrictionLaw law_of_friction(const Scene& scene) {
  const auto& options = *scene.effects.find<FrictionOptions>();
  FrictionLaw law{.coefficient = options.coefficient,
                  .stiffness_ratio = options.stiffness_ratio,
                  .damping_ratio = options.damping_ratio.value_or(options.stiffness_ratio),
                  .rolling_coefficient = options.rolling_coefficient};
  if (!options.tangential_restitution) return law;
  const LinearSpringLaw normal = linear_law(*scene.effects.find<LinearContactOptions>());
  law.stiffness_ratio = ratio_for(*options.tangential_restitution, normal, options.inertia);
  law.damping_ratio = 0;
  return law;
}

/// Draws Gaussian angular velocities for the populations that have a rotational temperature.
void set_rotational_temperature(const Draft& draft, Scene& scene) {
  constexpr std::uint64_t rotation = 1;  // distinguishes the sequence from that of velocities
  const double inertia = scene.effects.find<FrictionOptions>()->inertia;
  std::size_t i = draft.conductors.size();
  for (const PopulationDraft& population : draft.populations)
    for (const std::size_t end = i + population.count; i < end; ++i) {
      if (!population.rotational_temperature) continue;
      Conductor& grain = scene.conductors[i];
      Random random({.seed = scene.seed, .purpose = RandomPurpose::population, .i = i, .j = rotation});
      const double r = grain.radius,
                   mass = 4.0 / 3 * std::numbers::pi * scene.material.density * grain.material.density * r * r * r;
      const double width = std::sqrt(*population.rotational_temperature / (inertia * mass * r * r));
      for (int k = scene.dimension() == 3 ? 0 : 2; k < 3; ++k) grain.angular_velocity[k] = width * random.normal();
    }
}

std::vector<Key> friction_keys() {
  return {
      {.name = "coefficient",
       .target = target<&FrictionOptions::coefficient>,
       .range = ranges::not_negative,
       .help = "coefficient of friction mu: largest tangential over normal force"},
      {.name = "stiffness_ratio",
       .target = target<&FrictionOptions::stiffness_ratio>,
       .range = {.low = 0, .high = 100, .low_itself = false},
       .help = "stiffness of the tangential spring over that of the normal contact at the same overlap; with 2/7, "
               "sticking solid spheres oscillate with the frequency of the normal contact"},
      {.name = "damping_ratio",
       .target = target<&FrictionOptions::damping_ratio>,
       .range = {.low = 0, .high = 100},
       .computed_default = "stiffness_ratio",
       .help = "damping coefficient of the tangential spring over that of the normal contact"},
      {.name = "tangential_restitution",
       .target = target<&FrictionOptions::tangential_restitution>,
       .range = {.low = -0.99, .high = 1},
       .computed_default = "from stiffness_ratio and damping_ratio",
       .help = "tangential restitution beta_0 of two grains of mass m0 whose surfaces stick in the collision (Walton "
               "1993): -1 smooth, 1 perfectly rough. The tangential spring then has no damping. Only with "
               "[effects.linear_contact]"},
      {.name = "rolling_coefficient",
       .target = target<&FrictionOptions::rolling_coefficient>,
       .range = ranges::not_negative,
       .help = "coefficient of rolling resistance: largest torque against rolling over normal force and effective "
               "radius"},
      {.name = "inertia",
       .target = target<&FrictionOptions::inertia>,
       .range = {.low = 0, .high = 1, .low_itself = false},
       .help = "squared radius of gyration over squared radius, I / (m R^2): 2/5 for solid spheres, 2/3 for shells"}};
}

}  // namespace

const EffectKind& FrictionOptions::kind() {
  static const EffectKind kind = {
      .name = "friction",
      .description = "friction and rotation of grains",
      .help =
          "Grains rotate, and their surfaces have friction: a tangential spring with a dashpot, limited by Coulomb's "
          "law "
          "(Cundall and Strack 1979), and rolling resistance.",
      .options = FrictionOptions{},
      .keys = friction_keys(),
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_friction,
      .complete = set_rotational_temperature,
      .make =
          [](const Scene& scene) {
            return std::make_unique<SurfaceEffect>(
                FrictionOptions::kind(),
                [law = law_of_friction(scene), inertia = scene.effects.find<FrictionOptions>()->inertia](
                    SurfaceLaw& surface) { surface.friction = law, surface.inertia = inertia; });
          },
      .explain = [](const Scene& scene) -> std::vector<ExplanationLine> {
        const FrictionLaw law = law_of_friction(scene);
        return {{"friction",
                 fmt::format("mu = {:.4g}, k_t / k_n = {:.4g}, tangential over normal damping {:.4g}, mu_r = "
                             "{:.4g}",
                             law.coefficient, law.stiffness_ratio, law.damping_ratio, law.rolling_coefficient)}};
      },
      .device = [](const Scene&, DeviceForces&) {}};
  return kind;
}

}  // namespace lichtenberg::effects
