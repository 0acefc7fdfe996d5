#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/device/device.hpp"
#include "tests/grains.hpp"

/// Gases for tests of the device kernels.
namespace lichtenberg::device_gases {

inline Scene gas(int count, double edge, double temperature) {
  Scene scene = grains::cube(edge);
  grains::add_gas(scene, count, edge - 1.1, temperature);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 278.6, .dissipative = 27.7});
  return scene;
}

inline Scene charged_gas(int count, double edge, double temperature) {
  Scene scene = gas(count, edge, temperature);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 ? 1 : -1;
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-6});
  scene.effects.add(effects::ChargeExchangeOptions{.strength = 0.05});
  return scene;
}

inline Scene polarized_gas() {
  Scene scene = charged_gas(100, 8, 1);
  scene.effects.add(effects::InducedDipolesOptions{.polarizability = 0.02, .tolerance = 1e-6});
  return scene;
}

inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0;
  REQUIRE(a.size() == b.size());
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

using Device = std::unique_ptr<granular::device::DeviceGas>;

/// Device that the CPU executes item by item, with the state of a checkpoint and the laws of a gas.
inline Device loaded(const Scene& scene, const grains::Run& cpu, const Checkpoint& checkpoint) {
  Device device = granular::device::make_host_gas(scene);
  device->load(checkpoint, cpu.gas.law(), cpu.gas.in_elastic_stage(), cpu.gas.stage_begin(), cpu.gas.surface());
  return device;
}

/// The checkpoint with the state of the device.
inline Checkpoint stored(const granular::device::DeviceGas& device, Checkpoint checkpoint) {
  device.store(checkpoint);
  return checkpoint;
}

/// A gas on the CPU and one on a device, both at the checkpoint `start`.
struct OnBoth {
  explicit OnBoth(const Scene& scene) : cpu(scene), start(cpu.gas.save()), device(loaded(scene, cpu, start)) {}
  grains::Run cpu;
  Checkpoint start;
  Device device;
};

inline double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

}  // namespace lichtenberg::device_gases
