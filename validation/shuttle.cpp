// Charge shuttle (D 4.2): charge per crossing, crossing time and current of a run against exact two-dimensional theory
// (validation/theory/disk_between_plates.hpp). Also tests the effects of inertia, voltage, gap, contact gap and cells.
//
//   shuttle          seconds
//   shuttle long     more gaps, finer grids

#include <array>
#include <functional>
#include <map>
#include <numbers>

#include "src/effects/contact_discharge.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/spheres.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"
#include "validation/theory/disk_between_plates.hpp"
#include "validation/theory/shuttle.hpp"

namespace shuttle_validation {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;
using namespace lichtenberg::validation;

namespace {

constexpr double steel = 8050, weightless = 8.05;  // kg/m^3; the relaxation time of the latter is 1.5 us

struct Set {
  double gap;             ///< m; path from plate to plate
  double voltage = 18e3;  ///< V
  double density = weightless;
  int cells = 192;            ///< along the plates, which are three times as long as their distance
  double contact_gap = 0.01;  ///< radii
};

double distance(const Set& set) { return set.gap + 2 * radius; }
/// Returns the gap at which the contact opens: hysteresis of at least the position tolerance.
double lost_gap(const Set& set) { return set.contact_gap * radius + std::max(0.05 * set.contact_gap, 1e-3) * radius; }

/// Returns the sphere at rest on the left plate.
Scene scene_of(const Set& set) {
  const double h = distance(set);
  Scene scene = steel_spheres::scene_of({{radius, 1.5 * h}});
  scene.domain.size = {h, 3 * h};
  scene.domain.sides[0] = {.electrode = true, .potential = 0.5 * set.voltage};
  scene.domain.sides[1] = {.electrode = true, .potential = -0.5 * set.voltage};
  scene.material.density = set.density;
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add<effects::StokesDragOptions>();
  scene.effects.add<effects::WallContactOptions>();
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = set.contact_gap * radius, .hysteresis = 0.05});
  scene.field().cells = set.cells;
  return scene;
}

/// Properties of one crossing, by theory or from a run.
struct Crossing {
  double charge = 0;                                ///< C, transported from plate to plate
  double time = 0;                                  ///< s
  double current() const { return charge / time; }  ///< A; 2 charge per two crossings
};

/// Theory of a crossing. The contact closes at contact_gap before a plate, which then repels the sphere, and opens at
/// lost_gap, where the charge becomes constant.
struct Theory {
  Crossing overdamped;
  std::function<Crossing()> ballistic;
};
Theory theory_of(const Set& set, double depth, double permittivity) {
  const theory::DiskBetweenPlates disk = {radius, distance(set), set.voltage, permittivity};
  const double made = set.contact_gap * radius, lost = lost_gap(set);
  const auto held = [=](double x) { return theory::at_potential(disk, x, 0.5 * set.voltage); };
  const double charge = held(-disk.position_at_gap(lost)).charge, from = -disk.position_at_gap(lost),
               to = disk.position_at_gap(made);
  const auto force = [=](double x) { return depth * theory::with_charge(disk, x, charge).force; };
  const double at_plate =
      theory::overdamped_time([&](double x) { return depth * held(x).force; }, drag, -disk.position_at_gap(made), from);
  return {{charge * depth, at_plate + theory::overdamped_time(force, drag, from, to)}, [=] {
            return Crossing{charge * depth, theory::ballistic_time(force, drag, from, to)};
          }};
}
/// Returns the theory of a crossing, which is computed once for each gap, voltage and contact gap.
const Theory& theory_of(const Set& set) {
  static std::map<std::array<double, 3>, Theory> known;
  const std::array key = {set.gap, set.voltage, set.contact_gap};
  if (!known.contains(key)) {
    const Scene scene = scene_of(set);
    known[key] = theory_of(set, scene.medium.depth, scene.medium.permittivity);
  }
  return known[key];
}

/// Advances in intervals of `look` until `contacts` contacts have closed. Returns false if 200 crossings do not
/// suffice.
bool advance_to_contacts(Simulation& simulation, std::int64_t contacts, double look, double crossing) {
  const double latest = simulation.time() + 200 * crossing;
  while (simulation.counters().contacts_made < contacts && simulation.time() < latest)
    simulation.advance_to(simulation.time() + look);
  return simulation.counters().contacts_made >= contacts;
}

/// Returns the mean of `crossings` crossings after the initial transient of inertia (steel). The first and last contact
/// have a time resolution of expected / 64.
Crossing run(const Set& set, double expected, int crossings) {
  Simulation simulation(scene_of(set));
  const double coarse = expected / 8, fine = expected / 64;
  simulation.now();  // closes the contact at rest
  simulation.advance_to(8 * set.density / steel * relaxation);
  const std::int64_t first = simulation.counters().contacts_made + 1;
  if (!advance_to_contacts(simulation, first, fine, expected)) return {};
  const double start = simulation.time();
  if (!advance_to_contacts(simulation, first + crossings - 1, coarse, expected)) return {};
  if (!advance_to_contacts(simulation, first + crossings, fine, expected)) return {};
  const double time = (simulation.time() - start) / crossings;
  simulation.advance_to(simulation.time() + 0.3 * expected);  // the sphere has left the plate
  return {std::abs(simulation.now().charge[0]), time};
}

std::string name_of(const Set& set) {
  return fmt::format("g = {:g} mm, {:g} kV, S = {}, contact {:g} R: ", 1e3 * set.gap, 1e-3 * set.voltage, set.cells,
                     set.contact_gap);
}

constexpr int crossings = 6;
/// Time resolution of contacts: 1/64 crossing.
constexpr double seen = 1.0 / 64 / crossings;

double cells_in_radius(const Set& set) { return radius * set.cells / (3 * distance(set)); }

/// Returns the bound on the relative error of the charge. Grid: as for a disk at its plate's potential, as smooth as
/// two disks at d = 4R (validation/two_disks: 0.02 % at R = 8 cells, decreasing as h^2). Time coupling: at opening, the
/// charge is extrapolated from a position in contact, where it grows by the fraction gap / 3R.
double charge_bound(const Set& set) {
  return 2e-4 * std::pow(8 / cells_in_radius(set), 2) + lost_gap(set) / (3 * radius);
}

/// Returns the bound on the relative error of the time. Force errors are those of two_disks: 0.1 % at gaps beyond R and
/// at most 3.5 % at smaller ones, where the sphere spends at most 2 R / g of its time.
double time_bound(const Set& set) {
  const double near = std::min(1.0, 2 * radius / set.gap);
  return (1e-3 + 0.035 * near) * std::pow(8 / cells_in_radius(set), 2) + charge_bound(set) + seen;
}

/// Compares a run without inertia with the quadrature of the exact force.
Crossing overdamped(Report& report, const Set& set) {
  const Crossing exact = theory_of(set).overdamped;
  const Crossing found = run(set, exact.time, crossings);
  report.at_most(name_of(set) + "charge", std::abs(found.charge / exact.charge - 1), charge_bound(set));
  report.at_most(name_of(set) + fmt::format("time, of {:.3g} ms", 1e3 * exact.time),
                 std::abs(found.time / exact.time - 1), time_bound(set));
  return found;
}

/// Steel reflected by the plates is faster than without inertia, and at most as fast as at a constant speed.
void inertia(Report& report, Set set) {
  set.density = steel;
  const Theory& exact = theory_of(set);
  const Crossing found = run(set, exact.overdamped.time, crossings);
  const double bound = time_bound(set);
  report.at_most(name_of(set) + "steel's time over that without inertia", found.time / exact.overdamped.time,
                 1 + bound);
  report.at_least(name_of(set) + "and over that of constant speed", found.time / exact.ballistic().time, 1 - bound);
}

/// Tests R_E ~ 1 / V^2 (D 4.7), exact without inertia: all forces scale with V^2, all charges with V.
void voltage(Report& report, bool is_long) {
  std::vector<double> voltages, resistances;
  for (const double v : is_long ? std::vector{4.5e3, 9e3, 18e3} : std::vector{4.5e3, 18e3}) {
    const Set set = {.gap = 5e-3, .voltage = v};
    const Crossing found = run(set, theory_of(set).overdamped.time, crossings);
    voltages.push_back(v);
    resistances.push_back(v / found.current());
  }
  // Two values, a factor 4 apart, each with an error of at most `seen`. Otherwise the scenes differ only by units,
  // except for the position tolerance, which has no effect.
  report.at_most("exponent of R_E ~ V^-p, deviation from 2", std::abs(order(voltages, resistances) - 2),
                 2 * (seen + 1e-3) / std::log(4.0));
}

/// Tests larger contact gaps: the path is shorter and more charge is transferred, at h = R + gap by the factor sinh(u)
/// / u.
void contact_gaps(Report& report, bool is_long) {
  const Set real = {.gap = 10e-3, .contact_gap = 3e-3};
  const Crossing at_contact = theory_of(real).overdamped;
  for (const double gap : is_long ? std::vector<double>{1, 0.3, 0.1, 0.03, 0.01, 0.003} : std::vector<double>{0.1}) {
    const Set set = {.gap = 10e-3, .cells = is_long ? 384 : 192, .contact_gap = gap};
    const Crossing found = overdamped(report, set);
    fmt::print("    current, over that at .003 R: {:.4f}\n", found.current() / at_contact.current());
  }
}

void finer_grids(Report& report, bool is_long) {
  const Set set = {.gap = 5e-3};
  for (const int cells : is_long ? std::vector<int>{48, 96, 192, 384, 768} : std::vector<int>{48, 96}) {
    Set finer = set;
    finer.cells = cells;
    overdamped(report, finer);
  }
}

/// Prints the differences between two and three dimensions, and D's monopoles. Informative only.
void three_dimensions() {
  fmt::print("\n{:<8}{:>14}{:>14}{:>14}{:>14}{:>14}\n", "g (mm)", "2D plates", "3D: D 4.6", "corrected", "3D plates",
             "2D/3D charge");
  for (const double gap : {1e-3, 2e-3, 5e-3, 10e-3, 20e-3}) {
    const Set set = {.gap = gap};
    const Scene scene = scene_of(set);
    const Crossing flat = theory_of(set).overdamped;
    const double eps = scene.medium.permittivity;
    const theory::SphereShuttle shuttle = {radius, gap,  set.voltage,
                                           eps,    drag, theory::isolated_sphere_capacitance(radius, eps)};
    // Far from the plates, the speed is charge E / drag.
    const double field = set.voltage / distance(set), charge = theory::sphere_on_plate_charge(radius, eps, field);
    fmt::print("{:<8g}{:>14.4g}{:>14.4g}{:>14.4g}{:>14.4g}{:>14.3f}\n", 1e3 * gap, set.voltage / flat.current(),
               theory::resistance(shuttle) / 8, theory::resistance(shuttle),
               set.voltage * gap * drag / (charge * charge * field), flat.charge / charge);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  const bool is_long = long_run_requested(argc, argv);
  Report report("The charge shuttle between two plates, against exact two-dimensional theory");

  report.section("without inertia, relative errors: gaps");
  for (const double gap : is_long ? std::vector<double>{1e-3, 2e-3, 5e-3, 10e-3, 20e-3} : std::vector<double>{10e-3})
    overdamped(report, {.gap = gap, .cells = gap > 15e-3 ? 384 : 192});
  report.section("without inertia: cells");
  finer_grids(report, is_long);
  report.section("without inertia: contact gap");
  contact_gaps(report, is_long);
  report.section("voltage (D 4.7)");
  voltage(report, is_long);
  report.section("with the inertia of steel");
  for (const double gap : is_long ? std::vector<double>{1e-3, 2e-3, 5e-3, 10e-3} : std::vector<double>{1e-3})
    inertia(report, {.gap = gap});
  three_dimensions();
  return report.exit_status();
}

const lichtenberg::validation::Program program("shuttle", validate);

}  // namespace shuttle_validation
