#include "src/commands/gas_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/effects.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

constexpr double effective_mass = 0.5;  // of two grains of mass 1

double mass(const Scene& scene, const Conductor& grain) {
  return 4.0 / 3 * std::numbers::pi * scene.material.density * grain.material.density * std::pow(grain.radius, 3);
}

void check_homogeneous(const Scene& scene) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format(
        "{}: the scene is not allowed, because {}: theories of gases are for equal grains of diameter and mass 1 in "
        "three dimensions that cool freely in a periodic box",
        scene.path, why));
  };
  if (!scene.reference) refuse("it has no table [units]");
  if (scene.dimension() != 3) refuse("it has two dimensions");
  if (scene.conductors.empty()) refuse("it has no grains");
  const Box<3> box = scene.domain.box();
  if (!box.periodic(0) || !box.periodic(1) || !box.periodic(2)) refuse("its domain is not periodic along all axes");
  for (const Conductor& grain : scene.conductors)
    if (std::abs(grain.radius - 0.5) > 1e-9 || std::abs(mass(scene, grain) - 1) > 1e-9)
      refuse("not all its grains have diameter and mass 1");
  if (is_driven(scene)) refuse("an effect drives its grains");
  if (const std::string key = surface_key(scene); !key.empty())
    refuse(fmt::format("its grains are not smooth and equal with {}", key));
}

double rms_charge(const Scene& scene) {
  double squares = 0;
  for (const Conductor& grain : scene.conductors) squares += grain.charge * grain.charge;
  return std::sqrt(squares / static_cast<double>(scene.conductors.size()));
}

double mean_charge(const Scene& scene) {
  double sum = 0;
  for (const Conductor& grain : scene.conductors) sum += grain.charge;
  return sum / static_cast<double>(scene.conductors.size());
}

std::optional<GasParameters::Exchange> exchange_of(const Scene& scene) {
  const auto* options = scene.effects.find<effects::ChargeExchangeOptions>();
  if (!options || options->model == effects::ExchangeModel::none) return {};
  if (options->model != effects::ExchangeModel::impact || options->each_step || options->capacity)
    throw InputError(scene.path +
                     ": theories of charging are for effects.charge_exchange with model = \"impact\", once "
                     "a collision and without a capacity");
  return GasParameters::Exchange{options->strength, options->exponent};
}

}  // namespace

double grain_density(const Scene& scene) {
  double volume = 1;
  for (int k = 0; k < scene.dimension(); ++k) volume *= scene.domain.size[k];
  return static_cast<double>(scene.conductors.size()) / volume;
}

double initial_temperature(const Scene& scene) {
  for (auto stage = scene.stages.rbegin(); stage != scene.stages.rend(); ++stage)
    if (stage->temperature) return *stage->temperature;
  double sum = 0;
  for (const Conductor& grain : scene.conductors) sum += mass(scene, grain) * norm2(grain.velocity);
  return sum / (scene.dimension() * static_cast<double>(scene.conductors.size()));
}

double warm_up(const Scene& scene) {
  double sum = 0, warm = 0;
  for (const Stage& stage : scene.stages) {
    sum += stage.duration;
    if (stage.elastic || stage.temperature) warm = sum;
  }
  return warm;
}

double restitution(const GrainContactLaw& law, double speed) {
  return granular::expected_collision(law, effective_mass, 1, speed).restitution;
}

double contact_duration(const GrainContactLaw& law, double speed) {
  return granular::expected_collision(law, effective_mass, 1, speed).duration;
}

theory::Impacts GasParameters::impacts(bool last) const {
  theory::Impacts impacts{.restitution = [law = law](double v) { return restitution(law, v); }};
  if (exchange)
    impacts.charge_square = [e = *exchange](double v) {
      return theory::impact_charge_square(e.strength, e.exponent, effective_mass, v);
    };
  if (last)
    impacts.duration = [law = law](double at_temperature) {
      return theory::impact_mean(at_temperature, [&](double v, double) { return contact_duration(law, v); });
    };
  return impacts;
}

GasParameters gas_parameters(const Scene& scene) {
  check_homogeneous(scene);
  const GasParameters gas{.source = scene.path,
                          .grains = static_cast<double>(scene.conductors.size()),
                          .density = grain_density(scene),
                          .temperature = initial_temperature(scene),
                          .warm_up = warm_up(scene),
                          .end = scene.stop.time - warm_up(scene),
                          .law = granular::contact_law(scene, effects::make_model(scene)),
                          .coupling = number_in(scene, &EffectKind::charge_strength).value_or(0),
                          .charge = rms_charge(scene),
                          .mean_charge = mean_charge(scene),
                          .exchange = exchange_of(scene)};
  if (!(gas.temperature > 0)) throw InputError(scene.path + ": theories of gases are for grains that move, T > 0");
  if (!(gas.end > 0)) throw InputError(scene.path + ": the run ends before its warm-up, after which theory begins");
  return gas;
}

GasParameters source_gas() {
  return {.source = "the source's gas (G chapter 4)",
          .grains = 50016,
          .density = 50016 / (70.0 * 70 * 70),
          .temperature = 10,
          .end = 1e4,
          .law = ViscoelasticLaw{278.6, 27.7},
          .coupling = 1,
          .exchange = GasParameters::Exchange{4.5e-3, 0.83}};
}

GasParameters source_monopolar_gas() {
  GasParameters gas = source_gas();
  gas.source = "the source's gas of equal charges (G 4.1a)";
  gas.law = LinearSpringLaw{278.6, linear_damping(278.6, 0.9, effective_mass)};
  gas.coupling = 0.1, gas.charge = gas.mean_charge = 1, gas.exchange.reset();
  return gas;
}

}  // namespace lichtenberg
