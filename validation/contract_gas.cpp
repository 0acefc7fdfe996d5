// Accuracy contract of gases of grains and of their theories: random charged gases, collisions and runs.
//
//   contract_gas              a few cases: seconds
//   contract_gas long         500 cases of each guarantee
//   contract_gas FROM TO      the cases of these seeds

#include "solvers/error.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "src/effects/friction.hpp"
#include "src/effects/linear_contact.hpp"
#include "src/scene/contact_steps.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/kinetic.hpp"
#include "src/theory/restitution.hpp"
#include "tests/charge_integrals.hpp"
#include "tests/grains.hpp"
#include "validation/contract.hpp"
#include "validation/program.hpp"

namespace contract_gas_validation {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using namespace lichtenberg::validation;

namespace {

// Sums over periodic images.

double rms(const std::vector<double>& vectors) {
  double squares = 0;
  for (const double x : vectors) squares += x * x;
  return std::sqrt(3 * squares / static_cast<double>(vectors.size()));
}

/// Returns a gas of 20 to 400 charged grains that fill the box, or a part of it.
Scene charged_gas(CaseRandom& random, double accuracy) {
  const int count = random.whole(20, 400);
  const double edge = std::cbrt(count / random.logarithmic(0.01, 0.3));
  Scene scene = viscoelastic(random.chance(0.3) ? edge * random.uniform(1.2, 3) : edge);
  scene.effects.add(effects::CoulombOptions{.strength = random.logarithmic(0.1, 10), .accuracy = accuracy});
  scene.mechanics.step = INFINITY;
  scene.mechanics.contact_steps = contact_steps_for(accuracy);
  const auto seed = static_cast<std::uint64_t>(random.whole(1, 1 << 30));
  add_gas(scene, count, edge, random.logarithmic(0.1, 10), seed);
  const int kind = random.whole(0, 2);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    scene.conductors[i].charge = kind == 0 ? sign : kind == 1 ? random.normal() : sign * random.logarithmic(1e-3, 1);
  }
  return scene;
}

void check_forces(Contract& contract, CaseRandom& random) {
  static const Guarantee forces{"coulomb.accuracy: rms force of a gas", "Ewald's sum at 1e-12"};
  const double accuracy = random.pick({1e-1, 1e-2, 1e-3, 1e-4, 1e-5});
  const Scene scene = charged_gas(random, accuracy);
  granular::Gas gas(scene);
  const std::vector<double> found = gas.smooth_forces();
  const Bodies& bodies = gas.bodies();
  periodic::Response exact;
  periodic::Ewald(1e-12).evaluate({bodies.box.lengths, bodies.position, bodies.charge}, {}, parallel::Team::single(),
                                  exact);
  std::vector<double> difference = found;
  const double strength = scene.effects.find<effects::CoulombOptions>()->strength;
  for (std::size_t k = 0; k < found.size(); ++k) difference[k] -= strength * exact.force[k];
  contract.add(forces, accuracy, rms(difference) / (strength * rms(exact.force)));
}

/// Tests the residual of the polarizing field over the field of the charges, by a sum of its own.
void check_dipoles(Contract& contract, CaseRandom& random) {
  static const Guarantee residual{"induced_dipoles.tolerance: polarizing field", "Ewald's sum at 1e-13"};
  const Scene scene = charged_gas(random, 1e-3);
  granular::Gas gas(scene);
  const Bodies& bodies = gas.bodies();
  const periodic::Sources charges{bodies.box.lengths, bodies.position, bodies.charge};
  const double tolerance = random.pick({1e-2, 1e-4, 1e-6, 1e-8}), polarizability = random.uniform(0.001, 0.07);
  parallel::Team& alone = parallel::Team::single();
  periodic::Ewald ewald(1e-11), finer(1e-13);
  std::vector<double> dipole, field(3 * static_cast<std::size_t>(bodies.size()));
  periodic::Response response, polarizing;
  periodic::InducedDipoles(ewald, periodic::DipoleSum::ewald, polarizability, tolerance)
      .evaluate(charges, {}, alone, dipole, response);
  finer.evaluate(charges, {}, alone, polarizing);
  periodic::field_by(finer, charges, {}, alone)(dipole, field);
  for (std::size_t k = 0; k < field.size(); ++k) field[k] += polarizing.field[k] - dipole[k] / polarizability;
  contract.add(residual, tolerance, rms(field) / rms(polarizing.field));
}

// Contacts and motion.

/// Tests the energy after a collision, over that before it.
void check_collision(Contract& contract, CaseRandom& random) {
  static const Guarantee energy{"contact_substeps: energy after a collision", "collision by CVODE at 1e-12"};
  const double accuracy = random.pick({1e-3, 3e-4, 1e-4, 1e-5}), speed = random.logarithmic(0.1, 8);
  const double elastic = random.logarithmic(200, 1e5);
  // The dimensionless damping k is at most about 1, that is a restitution of 0.4.
  const double damping = random.chance(0.2) ? 0 : random.logarithmic(1e-3, 1);
  const theory::ViscoelasticPair pair{elastic, damping * elastic / std::pow(elastic / 0.5, 0.4) / std::pow(speed, 0.2)};
  if (speed > 0.5 * theory::piercing_speed(pair)) return;
  Scene scene = cube(10);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = elastic, .dissipative = pair.dissipative});
  scene.mechanics.contact_steps = contact_steps_for(accuracy);
  scene.mechanics.step = random.logarithmic(1e-3, 0.05);
  const double found = restitution(scene, speed, random.uniform(0, 1));
  const double exact = theory::collision(pair, speed).restitution;
  contract.add(energy, accuracy, std::abs(found * found - exact * exact));
}

/// Returns the strongest attraction P of two grains in contact, strength * |q_i q_j| of opposite charges.
double strongest_attraction(const Scene& scene) {
  const auto [least, most] = std::ranges::minmax(scene.conductors, {}, &Conductor::charge);
  return -scene.effects.find<effects::CoulombOptions>()->strength * least.charge * most.charge;
}

/// Stiffens contacts so that no pair that falls from rest passes through itself, which the program refuses. Grains
/// attracted from rest far away have the kinetic energy P / (1 - xi) at an overlap xi. Contacts of stiffness E store
/// 2/5 E xi^(5/2). They stop the grains if E max(2/5 (1 - xi) xi^(5/2)) > P; the maximum is 0.0492, at xi = 5/7. With
/// E = 278.6 grains of 16 in 500 gases passed through each other, also with finer steps and forces; P was up to 69.
void stiffen(Scene& scene) {
  double& elastic = scene.effects.find<effects::ViscoelasticContactOptions>()->elastic;
  elastic = std::max(elastic, strongest_attraction(scene) / 0.0492);
}

/// Tests the energy of a charged gas that cools for about three collisions of each grain. The sum of forces, and outer
/// steps h in a gas of Maxwellian velocities, have errors of `accuracy` of the forces. Grains that fall on each other
/// are faster. The steps omit h^2/12 of the second derivative of their force. Its work in a fall from rest far away is
/// 7/12 h^2 P^2 for grains of mass and diameter 1, that is 7/12 h^2 P of the potential energy.
void check_energy(Contract& contract, CaseRandom& random) {
  static const Guarantee balance{"coulomb.accuracy: energy of a cooling gas", "energy balance"};
  const double accuracy = random.pick({1e-2, 1e-3, 1e-4});
  Scene scene = charged_gas(random, accuracy);
  stiffen(scene);
  Run run(scene);
  const granular::GasEnergy start = run.gas.energy();
  const double count = run.gas.bodies().size(), temperature = 2 * start.kinetic / (3 * count);
  const double volume = std::pow(scene.domain.size.x, 3);
  const double stop = std::min(3 / theory::collision_frequency(count / volume, temperature), 10.0);
  granular::GasEnergy end = start;
  double work_in_falls = 0;
  while (run.gas.time() < stop) {
    const double time = run.gas.time(), potential = end.potential;
    run.step(stop);
    end = run.gas.energy();
    const double step = run.gas.time() - time;
    work_in_falls += 7.0 / 12 * step * step * strongest_attraction(scene) * std::abs(end.potential - potential);
  }
  // The energy that contacts and forces have exchanged: dissipated, and changes of the potential energy.
  const double exchanged = start.kinetic + end.dissipated + std::abs(end.potential - start.potential);
  contract.add(balance, accuracy + work_in_falls / exchanged, std::abs(end.total() - start.total()) / exchanged);
}

// Theories.

void check_theories(Contract& contract, CaseRandom& random) {
  static const Guarantee restitution_guarantee{"theory: restitution", "equation of motion by CVODE"},
      duration{"theory: duration of a collision", "equation of motion by CVODE"},
      merging{"theory: rates of coalescence", "quadrature over charges"}, haff{"theory: cooling gas", "closed form"};
  const double damping = random.logarithmic(1e-4, 50);
  const theory::UniversalCollision found = theory::restitution_curve()(damping),
                                   exact = theory::universal_collision(damping);
  contract.add(restitution_guarantee, 1e-11, std::abs(found.loss - exact.loss));
  contract.add(duration, 1e-9, std::abs(found.duration - exact.duration));
  const double beta = 2 * random.logarithmic(1e-4, 1e3);
  const double by_quadrature = over_charges([&](double w) { return h_number(beta * w); });
  contract.add(merging, 1e-10, std::abs(theory::merging_integrals(beta).number / by_quadrature - 1));
  const double density = random.uniform(0.01, 0.3), epsilon = random.uniform(0.3, 0.99),
               initial = random.uniform(0.1, 9);
  const std::vector<double> times = {random.logarithmic(0.1, 100)};
  const double cooled =
      theory::cool(density, {.restitution = [&](double) { return epsilon; }}, initial, times)[0].temperature;
  // The mean of (1 - eps^2) x in cool() is that of the energy loss, so that the temperature obeys Haff's law.
  const double law = theory::haff_temperature(initial, theory::haff_time(density, initial, epsilon), times[0]);
  contract.add(haff, 1e-9, std::abs(cooled / law - 1));
}

void check(Contract& contract, std::uint64_t seed) {
  CaseRandom sums(seed, 1), dipoles(seed, 2), collision(seed, 3), motion(seed, 4), theories(seed, 5);
  check_forces(contract, sums);
  check_dipoles(contract, dipoles);
  for (int k = 0; k < 4; ++k) check_collision(contract, collision);
  check_energy(contract, motion);
  check_theories(contract, theories);
}

}  // namespace

int validate(int argc, char** argv) { return Contract().run("gases of grains", argc, argv, 4, 500, check); }

const lichtenberg::validation::Program program("contract_gas", validate);

}  // namespace contract_gas_validation
