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

/// Difficult cases of gases, their observables and bounds. Used by hard_cases_gas.cpp (CPU) and device/hard_cases.cpp
/// (device). Reduced units. Contacts of cooling gases and bound pairs have the substeps that a scene of that accuracy
/// would have.
namespace lichtenberg::gas_cases {

/// Makes an empty scene in a periodic cube with viscoelastic contacts, with the contact law's damping D (`dissipative`)
/// and stiffness E (`elastic`). `edge`: edge of the cube.
inline Scene viscoelastic(double edge, double dissipative = 27.7, double elastic = 278.6) {
  Scene scene = grains::cube(edge);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = elastic, .dissipative = dissipative});
  return scene;
}

/// Computes the sizes of clusters of grains in contact.
inline analysis::ClusterSizes clusters(const granular::Gas& gas) {
  return analysis::cluster_sizes(analysis::cluster_numbers(gas.bodies().size(), granular::pairs_in_contact(gas)));
}

/// Computes the error of the energy balance since the energy was `start`, relative to the dissipated energy.
inline double left_over(const granular::GasEnergy& now, double start) {
  return std::abs(now.total() - start) / now.dissipated;
}

/// Makes a scene of 50 charged grains at T = 10 that cool until they rest in one cluster.
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

/// Makes a scene of one grain of charge 12 surrounded by twelve grains of charge -1, at rest.
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

/// Dilute elastic gas of n grains, with bounds on the number of collisions and the energy error.
///
/// Contacts take the fraction omega t_c of the time between collisions, 1/omega. The number of collisions is Poisson
/// distributed, with a relative error below the inverse root of the number. Carnahan and Starling's pair correlation
/// at contact has an error of 1e-3 here. The error of the restitution is +-1e-4 with 25 substeps per contact; in the
/// worst case, the errors of all collisions of a grain add up.
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
  /// Computes the expected number of collisions in a time t, omega N t / 2, with the collision frequency omega of a
  /// grain.
  double collisions(double temperature, double time) const {
    return 0.5 * theory::collision_frequency(density, temperature) * n * time;
  }
  /// Returns the bound on the relative error of the number of collisions.
  double bound(double collisions) const {
    const double late = theory::collision_frequency(density, 1) * 3.2 * std::pow(0.25 / (elastic * elastic * 1.5), 0.2);
    return 3 / std::sqrt(collisions) + late + 0.002;
  }
  /// Returns the bound on the relative energy error.
  double bound_of_energy(double collisions) const { return 1e-4 * 2 * collisions / n; }
};

/// Makes a scene of 250 charged elastic grains at T = 1e-5.
inline Scene cold_gas() {
  Scene scene = viscoelastic(16, 0);
  scene.effects.add(effects::CoulombOptions{.strength = 1e-5, .accuracy = 1e-3});
  grains::add_gas(scene, 250, 15.9, 1e-5);
  grains::charge_alternately(scene, 1);
  return scene;
}
/// Returns the initial kinetic energy of cold_gas().
inline double kinetic_energy_of_cold_gas() { return 1.5 * 250 * 1e-5; }

/// Computes the bound on the growth of the cold gas's energy in a time, relative to its kinetic energy; `forces`:
/// initial forces on the grains. Persistent force errors dF = 1e-3 of the rms force give dF^2 t^2 / 2m per grain, an
/// upper bound of (2/3) dF^2 t_corr / m per unit time.
/// In addition, bound pairs (K q^2 = T) bounce every two units of time. An elastic contact with 45 substeps has an
/// energy error of up to 5e-5 with either sign, depending on the phase of the step at onset. The accumulated error may
/// be 1e-6 per bounce, less than that of a single bounce.
inline double bound_of_cold_gas(const std::vector<double>& forces, double time) {
  double squares = 0;
  for (const double f : forces) squares += f * f;
  return 0.5 * 1e-6 * squares * time * time / kinetic_energy_of_cold_gas() + 1e-6 * time / 2;
}

/// Makes a scene of n grains that exchange charge in contacts and cool from T = 10.
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

/// Makes a scene of 150 cold grains, one of them a thousand times as fast as the others.
inline Scene one_fast_grain() {
  Scene scene = viscoelastic(8);
  grains::add_gas(scene, 150, 7.9, 1e-4);
  scene.conductors.front().velocity = {7, 5, 3};
  return scene;
}

/// Counts of overlapping pairs of grains, and of overlapping pairs that the gas has not registered as contacts.
struct Overlaps {
  double seen = 0, missed = 0;

  /// Counts the pairs of a gas by comparing all pairs.
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

/// Case of two grains that attract each other and vibrate in contact.
struct BoundPair {
  double attraction;  ///< K q^2

  /// Returns the overlap at rest.
  double overlap() const { return std::pow(attraction / 278.6, 2.0 / 3); }
  /// Returns the period of vibration.
  double period() const { return 2 * std::numbers::pi * std::sqrt(0.5 / (1.5 * 278.6 * std::sqrt(overlap()))); }
  Scene scene(double dissipative, effects::CoulombOptions coulomb) const {
    Scene scene = viscoelastic(30, dissipative);
    coulomb.strength = attraction;
    scene.effects.add(coulomb);
    scene.mechanics.contact_steps = contact_steps_for(1e-3);
    grains::add_pair(scene, 0, -1.3 * overlap(), 1);
    return scene;
  }
  /// Returns the bound on the energy change over fifty periods, relative to K q^2 times the overlap, for steps up to a
  /// quarter of a period. The contact neglects changes of the slow force within a step, K q^2 2 a for amplitudes a of
  /// .3 overlap. The work is at most .3 x 2 x .3 of K q^2 overlap^2 per period, with either sign. Over 50 periods this
  /// gives 9 overlaps.
  double bound() const { return 9 * overlap(); }
};

}  // namespace lichtenberg::gas_cases
