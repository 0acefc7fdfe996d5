#include "src/granular/homogeneous_gas.hpp"

#include <algorithm>
#include <cmath>

#include "src/analysis/gas_distributions.hpp"
#include "src/analysis/gas_temperature.hpp"
#include "src/effects/charge_exchange.hpp"

namespace lichtenberg::granular {
namespace {

constexpr double effective_mass = 0.5;  // of two grains of mass 1

/// Returns true for grains of diameter and mass 1 in a box that is periodic along all axes.
bool are_unit_grains(const Bodies& b) {
  const auto is = [](double wanted) { return [wanted](double value) { return std::abs(value - wanted) < 1e-9; }; };
  return b.dimension == 3 && b.box.periodic(0) && b.box.periodic(1) && b.box.periodic(2) &&
         std::ranges::all_of(b.radius, is(0.5)) && std::ranges::all_of(b.mass, is(1));
}

/// Returns the parameters of the scene's charge exchange if theory::impact_charge_square applies to it; otherwise null.
const effects::ChargeExchangeOptions* known_exchange(const Scene& scene) {
  const auto* options = scene.effects.find<effects::ChargeExchangeOptions>();
  const bool known =
      options && options->model == effects::ExchangeModel::impact && !options->each_step && !options->capacity;
  return known ? options : nullptr;
}

/// Returns the integral over a time dt of a function c / (t + const), such as the collision frequency of a cooling gas.
/// Its values are a at the start and b at the end.
double integral(double a, double b, double dt) {
  return std::abs(a - b) < 1e-6 * a ? dt * a : dt * a * b * std::log(a / b) / (a - b);
}

}  // namespace

std::optional<HomogeneousGas> HomogeneousGas::of(const Gas& gas) {
  const Bodies& bodies = gas.bodies();
  const bool driven = is_driven(gas.scene());
  constexpr int fewest = 100;  // with fewer, the temperature fluctuates by more than sqrt(2 / 3N), 8 %
  if (bodies.size() < fewest || !are_unit_grains(bodies) || driven || !(gas.fastest() > 0) ||
      !surface_key(gas.scene()).empty())
    return {};
  return HomogeneousGas(gas);
}

HomogeneousGas::HomogeneousGas(const Gas& gas)
    : grains_(gas.bodies().size()), has_exchange_(known_exchange(gas.scene()) != nullptr) {
  const Vec3 lengths = gas.bodies().box.lengths;
  density_ = grains_ / (lengths.x * lengths.y * lengths.z);
  begin(gas);
}

theory::Impacts HomogeneousGas::impacts(const Gas& gas) const {
  const auto expected = [law = gas.law()](double speed) { return expected_collision(law, effective_mass, 1, speed); };
  theory::Impacts impacts{.restitution = [=](double speed) { return expected(speed).restitution; }};
  impacts.duration = [=](double temperature) {
    return theory::impact_mean(temperature, [&](double speed, double) { return expected(speed).duration; });
  };
  if (const auto* exchange = known_exchange(gas.scene()); exchange && !gas.in_elastic_stage())
    impacts.charge_square = [=](double speed) {
      return theory::impact_charge_square(exchange->strength, exchange->exponent, effective_mass, speed);
    };
  return impacts;
}

double HomogeneousGas::frequency(double temperature) const {
  const double frequency = theory::collision_frequency(density_, temperature);
  return frequency / (1 + frequency * means_->duration(temperature));
}

/// Computes the table of means over impacts for the contact law of the current stage.
void HomogeneousGas::take_law(const Gas& gas) {
  if (stage_ == gas.stage_begin()) return;
  means_.emplace(impacts(gas));
  stage_ = gas.stage_begin();
}

void HomogeneousGas::begin(const Gas& gas) {
  take_law(gas);
  time_ = gas.time();
  temperature_ = analysis::granular_temperature(gas.bodies()).total;
  charge_square_ = analysis::charge_moments(gas.bodies().charge).square;
  frequency_ = frequency(temperature_);
}

void HomogeneousGas::follow(const Gas& gas, double time, double temperature) {
  const double dt = time - time_;
  if (!(dt > 0) || !(temperature > 0)) return;
  take_law(gas);
  if (!gas.in_elastic_stage()) {
    const theory::CoolingState state = theory::cool(density_, *means_, temperature_, std::span(&dt, 1)).front();
    temperature_ = state.temperature;
    charge_square_ += state.charge_square;
  }
  const double before = frequency_;
  frequency_ = frequency(temperature);
  collisions_ += 0.5 * grains_ * integral(before, frequency_, dt);
  time_ = time;
}

std::optional<double> HomogeneousGas::charge_square() const {
  return has_exchange_ ? std::optional(charge_square_) : std::nullopt;
}

void HomogeneousGas::save(Checkpoint& checkpoint) const {
  checkpoint.reals["homogeneous_gas"] = {time_, temperature_, charge_square_, collisions_, frequency_};
}

void HomogeneousGas::restore(const Checkpoint& checkpoint) {
  const std::vector<double>& saved = reals(checkpoint, "homogeneous_gas", 5);
  time_ = saved[0], temperature_ = saved[1], charge_square_ = saved[2], collisions_ = saved[3], frequency_ = saved[4];
}

}  // namespace lichtenberg::granular
