// Energy balance of a run with all charge transport: a sphere shuttles between two electrodes, one of them behind a
// resistor, in a conducting fluid. The energy from the potential sources is stored in the field, in motion and in
// elastic contacts, or is dissipated in the resistor, the fluid, sparks and drag:
//
//   d(field + kinetic + elastic) = supplied - dissipated.
//
// Each term has its own formula (src/mechanics/energy_budget.hpp), so the remainder measures the error of the run. Its
// bound: in a coupling step, the force error displaces a body by at most position_tolerance, with the work |F|
// tolerance. The charge error is at most tolerance / radius of the largest charge, at the potential difference V:
// energy Q V tolerance / radius. Both count once per step, with equal signs. The field solver's part is measured
// separately. It is the difference between the work of the force along the gap at constant charge and the energy change
// of the same solver, as a fraction of the work.
//
// This allows a few per cent, which a missing term could fit. A missing term would not depend on the step. The
// remainder due to the mean potential of a step (energy_budget.hpp) decreases with the square of the number of steps.
// The order of the remainder is therefore measured.

#include <memory>

#include "src/analysis/circuit.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace energy_balance_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

constexpr double voltage = 18e3, radius = 0.775e-3, size = 1.2e-2;

Scene shuttle(int cells, double position_tolerance) {
  return parse_scene(fmt::format(R"(
domain.size = [{0}, {0}]
medium = {{ relative_permittivity = 4.7, viscosity = 0.7, depth = 1.55e-3 }}
[[electrode]]
shape = "bar"
from = [0.0, 0.0]
to = [0.0, {0}]
width = 5e-3
potential = {1}
series_resistance = 3e11
[[electrode]]
shape = "bar"
from = [{0}, 0.0]
to = [{0}, {0}]
width = 5e-3
potential = 0.0
[[conductor]]
position = [4.5e-3, 6e-3]
radius = {2}
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 2e-4
[effects.leakage]
conductivity = 2e-10
[field]
cells = {3}
[mechanics]
position_tolerance = {4}
[stop]
time = 1.5
)",
                                 size, voltage, radius, cells, position_tolerance),
                     "shuttle.toml");
}

/// Returns the difference between the work of the force through the gap and the field's energy loss, as a fraction of
/// the work. Without contacts and resistor, for one charged sphere.
double field_error(int cells) {
  Scene scene = shuttle(cells, 1e-3 * radius);
  scene.electrodes[0].series_resistance = 0;
  scene.electrodes[0].potential = 0;
  const std::unique_ptr<laplace::LaplaceSolver> solver = effects::make_field_solver(scene.field());
  Bodies bodies = make_bodies(scene);
  const double from = 2.5e-3 + radius + 2e-4, to = 0.5 * size;
  const int points = 200;
  double work = 0, done = 0, energy = 0, last_energy = 0, last_force = 0, first_energy = 0;
  for (int k = 0; k <= points; ++k) {
    bodies.position[0] = from + (to - from) * k / points;
    const effects::ElectricalGroups groups = effects::electrical_groups(scene, {});
    const laplace::LaplaceSolution solution =
        solver->solve(effects::make_laplace_problem(scene, bodies, groups, {.charge = {1e-9}}));
    energy = solution.energy;
    const double force = solution.body_force[0].x;
    if (k == 0) first_energy = energy;
    if (k > 0) {
      const double dx = (to - from) / points;
      work += 0.5 * (force + last_force) * dx;
      done += std::abs(0.5 * (force + last_force) * dx);
    }
    last_force = force;
    last_energy = energy;
  }
  return std::abs(work - (first_energy - last_energy)) / done;
}

struct Rest {
  double steps = 0, field_solver = 0, fraction = 0;  ///< fractions of the supplied energy, the latter two
};

Rest run(Report& report, int cells, double position_tolerance) {
  const Scene scene = shuttle(cells, position_tolerance);
  Simulation simulation(scene);
  const auto total = [](const ConductorFrame& f) {
    return f.energy + f.energy_balance->kinetic + f.energy_balance->elastic - f.energy_balance->flows.supplied() +
           f.energy_balance->flows.dissipated();
  };
  const double start = total(simulation.now());
  double worst = 0, largest_force = 0, largest_charge = 0;
  ConductorFrame frame;
  for (int k = 1; k <= 75; ++k) {
    simulation.advance_to(0.02 * k);
    frame = simulation.now();
    worst = std::max(worst, std::abs(total(frame) - start));
    largest_force = std::max(largest_force, norm(frame.force[0]));
    largest_charge =
        std::max({largest_charge, std::abs(frame.charge[0]), std::abs(frame.charge_held - frame.charge[0])});
  }
  const EnergyFlows& flows = frame.energy_balance->flows;
  const Counters& counters = simulation.counters();
  const double tolerance = scene.mechanics.position_tolerance;
  const double step = tolerance * (largest_force + largest_charge * voltage / radius);
  const double field = field_error(cells) * (flows.drag + flows.sparks);
  report.section(fmt::format("shuttle, {} cells: {} steps, {} solves, {} contacts made", cells, counters.steps,
                             counters.field_solves, counters.contacts_made));
  report.at_least("contacts made (or nothing was tested)", static_cast<double>(counters.contacts_made), 4);
  const auto share = [&](const std::string& what, double joule) {
    report.at_most(what + ", fraction of the supplied energy", joule / flows.supplied(), {});
  };
  share("heat in the resistor", flows.series_resistors);
  share("heat in the fluid by leakage", flows.leakage);
  share("sparks", flows.sparks);
  share("drag", flows.drag);
  report.at_most("residual of the energy balance, fraction of the supplied energy", worst / flows.supplied(),
                 (static_cast<double>(counters.steps) * step + field) / flows.supplied(),
                 fmt::format("of it by the field's solver {:.2g}", field / flows.supplied()));
  report.at_most("the same, with the bound of a run's summary", worst / flows.supplied(),
                 analysis::allowed_energy_imbalance(scene));
  const double balance = frame.charge_held + frame.charge_drained + frame.charge_leaked;
  report.at_most("stored + collected + leaked, fraction of the leaked charge", std::abs(balance / frame.charge_leaked),
                 1e-12);
  return {static_cast<double>(counters.steps), field / flows.supplied(), worst / flows.supplied()};
}

void shorter_steps(Report& report, int cells) {
  std::vector<double> steps, left;
  Rest rest;
  for (const double tolerance : {16e-3, 4e-3, 1e-3}) {
    rest = run(report, cells, tolerance * radius);
    steps.push_back(rest.steps);
    left.push_back(rest.fraction);
  }
  report.section("the same with less and less tolerance");
  // The last value may contain the whole error of the field solver, which does not decrease.
  const double flattened = -std::log(1 - rest.field_solver / rest.fraction) / std::log(steps.back() / steps.front());
  report.at_least("energy left over: order in the number of steps", order(steps, left), 2 - flattened);
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Energy of a shuttle behind a resistor in a leaking fluid");
  shorter_steps(report, 96);
  run(report, 192, 1e-3 * radius);
  if (long_run_requested(argc, argv)) run(report, 384, 1e-3 * radius);
  return report.exit_status();
}

const lichtenberg::validation::Program program("energy_balance", validate);

}  // namespace energy_balance_validation
