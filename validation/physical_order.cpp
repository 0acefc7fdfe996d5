// Order of convergence of the energy's fluctuation for each integrator with a step (Merz and Shirts 2018). It is the
// slope of the rms change of a conservative system's energy over the step.
//
//   physical_order         seconds
//   physical_order long    more samples
//
// Each sample (initial state) has a slope by least squares over four steps. The interval is that of the mean of the
// slopes (Student), at a significance of 1e-4 for all rows together. Terms of the next order shift a slope: if they are
// a quarter of the error at the longest step, of eight times the shortest, by ln(1.25) / ln(8) = 0.11.

#include <boost/math/distributions/students_t.hpp>

#include "src/mechanics/simulation.hpp"
#include "tests/grains.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace physical_order_validation {

using namespace lichtenberg;
using namespace lichtenberg::grains;
using namespace lichtenberg::validation;

namespace {

constexpr int rows = 9;
constexpr double significance = 1e-4 / rows, next_order = 0.11;

/// Tests the order of `error(seed, k)`, the rms change of the energy at the step `first` / 2^k.
void check_order(Report& report, const std::string& what, double expected, int samples,
                 const std::function<double(std::uint64_t seed, int k)>& error) {
  std::vector<double> slopes;
  double coarsest = 0, finest = 0;
  for (int seed = 1; seed <= samples; ++seed) {
    std::vector<double> resolution, errors;
    for (int k = 0; k < 4; ++k) {
      resolution.push_back(std::ldexp(1, k));
      errors.push_back(error(static_cast<std::uint64_t>(seed), k));
    }
    slopes.push_back(order(resolution, errors));
    coarsest += errors.front() / samples, finest += errors.back() / samples;
  }
  double mean = 0;
  for (const double slope : slopes) mean += slope / samples;
  const boost::math::students_t student(samples - 1);
  const double half =
      quantile(complement(student, significance / 2)) * spread(slopes).jitter / std::sqrt(samples - 1.0);
  report.at_most(fmt::format("{}: order {:g}, found {:.2f} +- {:.2f}, off by", what, expected, mean, half),
                 std::abs(mean - expected), half + next_order,
                 fmt::format("energy {:.1e} to {:.1e}", coarsest, finest));
}

/// Returns the root mean square of the changes of a sequence from its value at the index `from` on.
double rms_change(const std::vector<double>& values, std::size_t from = 0) {
  double squares = 0;
  for (std::size_t k = from; k < values.size(); ++k) squares += (values[k] - values[from]) * (values[k] - values[from]);
  return std::sqrt(squares / static_cast<double>(values.size() - from));
}

// Grains.

/// Charges of one sign that move without contacts, so that forces are smooth.
/// `from`: time at which the comparison begins.
double smooth_gas(Integrator integrator, double step, double from, std::uint64_t seed) {
  Scene scene = viscoelastic(6, integrator);
  scene.effects.add(effects::CoulombOptions{.strength = 1, .sum = effects::CoulombSum::ewald, .accuracy = 1e-12});
  add_gas(scene, 8, 6, 0.05, seed);
  for (Conductor& conductor : scene.conductors) conductor.charge = 1;
  Run run(scene);
  std::vector<double> energies;
  constexpr double end = 3.2;
  for (int n = 0; n <= std::lround(end / step); ++n) {
    if (n > 0) run.step_to(n * step);
    energies.push_back(run.gas.energy().total());
  }
  return rms_change(energies, static_cast<std::size_t>(std::lround(from / step)));
}

/// Returns the rms change of the energy in an elastic head-on collision, over phases of the steps at onset.
/// `steps`: number of steps in a contact.
double elastic_collision(Integrator integrator, int steps, std::uint64_t seed) {
  Random random({.seed = seed, .purpose = RandomPurpose::population});
  const double speed = random.uniform(0.5, 2);
  Scene scene = cube(10, integrator);
  scene.effects.add(effects::ViscoelasticContactOptions{.elastic = 2786, .dissipative = 0});
  scene.mechanics.contact_steps = steps;
  if (integrator != Integrator::multirate)  // the duration is 3.218 (m_eff^2 / (E^2 v))^(1/5)
    scene.mechanics.step = 3.218 * std::pow(0.25 / (2786.0 * 2786 * speed), 0.2) / steps;
  double squares = 0;
  constexpr int phases = 24;
  for (int n = 0; n < phases; ++n) {
    const double epsilon = restitution(scene, speed, (n + random.uniform(0, 1)) / phases);
    squares += std::pow(1 - epsilon * epsilon, 2) / phases;
  }
  return std::sqrt(squares);
}

void grains_in_motion(Report& report, int samples) {
  report.section("grains: charges of one sign, without contacts");
  for (const Integrator integrator : {Integrator::multirate, Integrator::verlet, Integrator::gear})
    check_order(report, std::string(name_of(integrator)), 2, samples,
                [i = integrator](std::uint64_t seed, int k) { return smooth_gas(i, std::ldexp(0.2, -k), 0, seed); });
  // The predictor is exact for polynomials of degree 5 in time: the velocity's error of a step is of h^5. The order is
  // thus 4 for all stable coefficients of the corrector. Gear's cancel this error; G's as printed do not.
  for (const auto& [integrator, order] : {std::pair{Integrator::gear, 5.0}, {Integrator::gear_printed, 4.0}})
    check_order(report, fmt::format("{} after its start", name_of(integrator)), order, samples,
                [i = integrator](std::uint64_t seed, int k) { return smooth_gas(i, std::ldexp(0.2, -k), 1.6, seed); });
  report.section("grains: elastic collision; steps of contacts");
  // Forces grow as (t - t_onset)^(3/2) after the onset. The rule for the work in the step that contains it has an error
  // of h^(5/2), which depends on the phase. The error of the smooth part of the contact is of the same order or higher.
  for (const Integrator integrator : {Integrator::multirate, Integrator::verlet})
    check_order(report, std::string(name_of(integrator)), 2.5, samples,
                [i = integrator](std::uint64_t seed, int k) { return elastic_collision(i, 16 << k, seed); });
}

// Conductors.

/// Conductors that repel each other without drag. `prepare` sets the integrator's step.
double conductors(std::uint64_t seed, const std::function<void(MechanicsOptions&)>& prepare) {
  using steel_spheres::radius;
  Random random({.seed = seed, .purpose = RandomPurpose::population});
  Scene scene = steel_spheres::scene_of({});
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * (i + random.uniform(0, 0.5)) / 3;
    scene.conductors.push_back(
        {.position = {0.05 + 4 * radius * std::cos(angle), 0.05 + 4 * radius * std::sin(angle), 0},
         .velocity = {random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), 0},
         .radius = radius,
         .charge = random.uniform(1e-10, 2e-10)});
  }
  scene.effects.add<effects::FloatingConductorsOptions>();
  prepare(scene.mechanics);
  Simulation simulation(scene, std::make_unique<LineCharges>());
  std::vector<double> energies;
  for (int n = 0; n <= 16; ++n) {
    simulation.advance_to(0.02 * n);
    const ConductorFrame frame = simulation.now();
    double energy = frame.energy;
    for (std::size_t i = 0; i < frame.velocity.size(); ++i)
      energy += 0.5 * simulation.model().bodies.mass[i] * norm2(frame.velocity[i]);
    energies.push_back(energy);
  }
  return rms_change(energies) / energies.front();
}

void conductors_in_motion(Report& report, int samples) {
  report.section("conductors: steps between field solves");
  check_order(report, "cvode, split", 2, samples, [](std::uint64_t seed, int k) {
    return conductors(seed, [k](MechanicsOptions& mechanics) {
      mechanics.position_tolerance = 1e3;  // the longest step counts alone
      mechanics.relative_tolerance = 1e-12;
      mechanics.largest_step = std::ldexp(0.02, -k);
    });
  });
  check_order(report, "euler", 1, samples, [](std::uint64_t seed, int k) {
    return conductors(seed, [k](MechanicsOptions& mechanics) {
      mechanics.integrator = Integrator::euler;
      mechanics.euler_field_step = mechanics.euler_step = std::ldexp(2e-3, -k);
    });
  });
}

}  // namespace

int validate(int argc, char** argv) {
  const int samples = long_run_requested(argc, argv) ? 40 : 6;
  Report report("Order of the energy's fluctuation");
  grains_in_motion(report, samples);
  conductors_in_motion(report, samples);
  return report.exit_status();
}

const lichtenberg::validation::Program program("physical_order", validate);

}  // namespace physical_order_validation
