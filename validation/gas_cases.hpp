#pragma once

#include <cmath>
#include <numbers>
#include <set>

#include "src/analysis/gas_clusters.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/note.hpp"
#include "src/scene/contact_steps.hpp"
#include "src/theory/haff.hpp"
#include "tests/grains.hpp"

/// Gases that are hard to follow, what is looked at in them, and bounds: for who follows them on the processor
/// (hard_cases_gas.cpp) and on a device (device/hard_cases.cpp). Reduced units. Contacts of gases
/// that cool and of bound pairs have as many steps as a scene of that accuracy would give them.
namespace lichtenberg::gas_cases {

/// Of grains whose contacts lose what `dissipative` (D) says.
inline Scene viscoelastic(double edge, double dissipative = 27.7, double elastic = 278.6) {
  Scene scene = grains::cube(edge);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = elastic, .dissipative = dissipative});
  return scene;
}

inline analysis::ClusterSizes clusters(const granular::Gas& gas) {
  return analysis::cluster_sizes(analysis::cluster_numbers(gas.bodies().size(), granular::pairs_in_contact(gas)));
}

/// Of the energy's book, of what was dissipated.
inline double left_over(const granular::GasEnergy& now, double start) {
  return std::abs(now.total() - start) / now.dissipated;
}

/// 50 charged grains at T = 10 that cool to rest in one cluster.
inline Scene to_one_cluster() {
  const int n = 50;
  const double edge = std::cbrt(n / 0.1);
  Scene scene = viscoelastic(edge);
  scene.effects.add(effects::CoulombOptions{.strength = 1, .accuracy = 1e-4});
  scene.mechanics.contact_steps = contact_steps_for(1e-4);
  grains::add_gas(scene, n, edge, 10);
  grains::charge_alternately(scene, 1);
  return scene;
}

/// One grain of charge 12 and twelve of -1 near it, at rest.
inline Scene thirteen_grains(const effects::CoulombOptions& coulomb) {
  Scene scene = viscoelastic(30);
  scene.effects.add(coulomb);
  grains::add(scene, 0.5 * scene.domain.size, {}, 12);
  grains::add_gas(scene, 12, 3.5, 0, 4);
  for (std::size_t i = 1; i < scene.conductors.size(); ++i) scene.conductors[i].charge = -1;
  scene.mechanics.step = 0.01;
  scene.mechanics.contact_steps = contact_steps_for(1e-3);
  return scene;
}

/// An elastic gas of n grains, dilute: how often they collide, and by how much that and its energy may be off.
///
/// Contacts last: of the time between collisions, 1/omega, a part omega t_c is spent in them. Statistics: the number is
/// Poisson's to better than its root. Carnahan and Starling's g is good to 1e-3 here. An elastic restitution is off by
/// 1e-4 to either side with 25 steps a contact; at worst all collisions of a grain add up.
struct ElasticGas {
  static constexpr double density = 0.05, elastic = 278600;
  int n;

  Scene scene(int contact_steps) const {
    const double edge = std::cbrt(n / density);
    Scene scene = viscoelastic(edge, 0, elastic);
    scene.mechanics.contact_steps = contact_steps;
    grains::add_gas(scene, n, edge, 1);
    return scene;
  }
  /// omega N t / 2
  double collisions(double temperature, double time) const {
    return 0.5 * theory::collision_frequency(density, temperature) * n * time;
  }
  double bound(double collisions) const {
    const double late = theory::collision_frequency(density, 1) * 3.2 * std::pow(0.25 / (elastic * elastic * 1.5), 0.2);
    return 3 / std::sqrt(collisions) + late + 0.002;
  }
  double bound_of_energy(double collisions) const { return 1e-4 * 2 * collisions / n; }
};

/// 250 charged elastic grains at T = 1e-5.
inline Scene cold_gas() {
  Scene scene = viscoelastic(16, 0);
  scene.effects.add(effects::CoulombOptions{.strength = 1e-5, .accuracy = 1e-3});
  grains::add_gas(scene, 250, 15.9, 1e-5);
  grains::charge_alternately(scene, 1);
  return scene;
}
inline double kinetic_energy_of_cold_gas() { return 1.5 * 250 * 1e-5; }

/// What its energy may grow by, over its kinetic one. Errors dF = 1e-3 of the rms force that last: dF^2 t^2 / 2m of
/// each grain, an upper bound of (2/3) dF^2 t_corr / m a unit of time. Beside them pairs that are bound, K q^2 = T,
/// bounce every two units. An elastic contact of 45 steps is wrong by up to 5e-5 of its energy, of either sign by the
/// phase of the step at touch; 1e-6 a bounce, less than a single one may be, is what is allowed to add up.
inline double bound_of_cold_gas(const std::vector<double>& forces, double time) {
  double squares = 0;
  for (const double f : forces) squares += f * f;
  return 0.5 * 1e-6 * squares * time * time / kinetic_energy_of_cold_gas() + 1e-6 * time / 2;
}

/// n grains that exchange charge and cool from T = 10.
inline Scene cooling_gas(int n) {
  const double edge = std::cbrt(n / 0.4);
  Scene scene = viscoelastic(edge);
  scene.effects.add(effects::CoulombOptions{.strength = 2.469, .accuracy = 1e-3});
  scene.effects.add<effects::ChargeExchangeOptions>();
  scene.stages = {{.duration = 1, .stiffness = 10, .temperature = 10}};
  scene.mechanics.contact_steps = contact_steps_for(1e-3);
  grains::add_gas(scene, n, edge, 10);
  return scene;
}

/// 150 cold grains, one of them a thousand times as fast as the others.
inline Scene one_fast_grain() {
  Scene scene = viscoelastic(8);
  grains::add_gas(scene, 150, 7.9, 1e-4);
  scene.conductors.front().velocity = {7, 5, 3};
  return scene;
}

/// Pairs that overlap, and those of them that are no contacts.
struct Overlaps {
  double seen = 0, missed = 0;

  void look(const granular::Gas& gas) {
    const Bodies& b = gas.bodies();
    std::set<Pair> noted;
    for (const GrainContact& contact : gas.contacts()) noted.insert(contact.pair);
    for (int i = 0; i < b.size(); ++i)
      for (int j = i + 1; j < b.size(); ++j)
        if (norm(spheres<3>(b).box.difference(position<3>(b, i), position<3>(b, j))) < 1)
          ++seen, missed += !noted.contains({i, j});
  }
};

/// Two grains that attract each other and vibrate in contact.
struct BoundPair {
  double attraction;  ///< K q^2

  double overlap() const { return std::pow(attraction / 278.6, 2.0 / 3); }
  double period() const { return 2 * std::numbers::pi * std::sqrt(0.5 / (1.5 * 278.6 * std::sqrt(overlap()))); }
  Scene scene(double dissipative, effects::CoulombOptions coulomb) const {
    Scene scene = viscoelastic(30, dissipative);
    coulomb.strength = attraction;
    scene.effects.add(coulomb);
    scene.mechanics.contact_steps = contact_steps_for(1e-3);
    grains::add_pair(scene, 0, -1.3 * overlap(), 1);
    return scene;
  }
  /// Of the change of the energy in fifty periods, over K q^2 times the overlap, in steps up to a quarter of one: the
  /// contact feels the force of each instant but for what it changes within a step, by K q^2 2 a over amplitudes a of
  /// .3 overlaps: work of .3 x 2 x .3 of K q^2 overlap^2 a period at most if it always came at the wrong time, of
  /// either sign; 50 periods of it are 9 overlaps.
  double bound() const { return 9 * overlap(); }
};

}  // namespace lichtenberg::gas_cases
