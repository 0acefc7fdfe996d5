// Tests of the summary of a run of conductors: quantities, and warnings of energy, accuracy, overlaps and small disks.
#include "src/mechanics/summary.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "src/analysis/circuit.hpp"
#include "src/effects/field_choice.hpp"
#include "src/mechanics/energy_budget.hpp"
#include "tests/near.hpp"
#include "tests/spheres.hpp"

namespace mechanics_summary_test {

using namespace lichtenberg;
using namespace lichtenberg::steel_spheres;

namespace {

Scene one_conductor() { return conductor_scene({{0.02, 0.05}}); }

}  // namespace

TEST_CASE("energy_warning: only beyond the errors of steps, grid and field solves") {
  const Scene scene = one_conductor();
  mechanics::Outcome outcome;
  outcome.frame.energy_balance = EnergyBalance{.flows = {.by_supplies = 1, .contacts = 1}};
  outcome.initial_energy = 0;
  CHECK_EQ(mechanics::energy_warning(scene, outcome), "");
  outcome.frame.energy = 2 * analysis::allowed_energy_imbalance(scene);  // Relative to the supplied energy of 1 J.
  CHECK(mechanics::energy_warning(scene, outcome).starts_with("energy balance off by "));
  // With little supplied energy, two solves of the same field differ by more than that (mechanics/summary.cpp).
  const double solve = scene.field().moving_tolerance;
  outcome.frame.energy_balance = EnergyBalance{.flows = {.by_supplies = 10 * solve}};
  outcome.initial_energy = 1;
  outcome.frame.energy = 1 + 15 * solve;  // 5 are missing, half of the supplied energy.
  CHECK_EQ(mechanics::energy_warning(scene, outcome), "");
  outcome.frame.energy = 1 + 50 * solve;
  CHECK_NE(mechanics::energy_warning(scene, outcome), "");
}

TEST_CASE("energy imbalance without supply: is relative to the stored energy") {
  const Scene scene = one_conductor();
  mechanics::Outcome outcome{.initial_energy = 1};
  outcome.frame.energy_balance = EnergyBalance{};
  outcome.frame.energy = 1.5;
  const auto relative = [&] {
    const Summary summary = mechanics::summarize(scene, outcome);
    return std::ranges::find(summary.quantities, "relative_energy_imbalance", &Quantity::name)->value;
  };
  CHECK(relative() == near(0.5 / 1.5, 1e-12));
  CHECK(mechanics::energy_warning(scene, outcome).find("off by 33 % of the energy that is stored") !=
        std::string::npos);
  outcome.frame.energy = outcome.initial_energy = 0;
  CHECK(std::isnan(relative()));
  CHECK_EQ(mechanics::energy_warning(scene, outcome), "");
}

TEST_CASE("summary of conductors: overlaps and a missed accuracy give warnings") {
  Scene scene = one_conductor();
  mechanics::Outcome outcome{.largest_error = 2e-3, .largest_overlap = 0.3};
  scene.field().chosen_for = FieldAccuracy{.requested = 1e-3, .estimate = 1e-3};
  const std::vector<std::string> warnings = mechanics::summarize(scene, outcome).warnings;
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0].starts_with("accuracy not reached: "));
  CHECK(warnings[1].starts_with("bodies overlap by 30 % of a diameter: "));
  outcome = {.largest_error = 9e-4, .largest_overlap = 0.02};
  CHECK(mechanics::summarize(scene, outcome).warnings.empty());
}

TEST_CASE("largest_overlap: disk pairs not both fixed, free disks with sides") {
  Scene scene = conductor_scene({{0.02, 0.05}, {0.02 + 1.5 * radius, 0.05}, {0.05, 0.4 * radius}});
  CHECK(mechanics::largest_overlap(scene, make_bodies(scene)) == near(0.3, 1e-12));
  scene.conductors[2].fixed = true;
  CHECK(mechanics::largest_overlap(scene, make_bodies(scene)) == near(0.25, 1e-12));
  scene.conductors[0].fixed = scene.conductors[1].fixed = true;
  CHECK(mechanics::largest_overlap(scene, make_bodies(scene)) == 0);
}

TEST_CASE("unresolved_bodies: warns of radii below a cell, not for multipoles") {
  Scene scene = conductor_scene({{0.02, 0.05}, {0.03, 0.05}});
  scene.field().cells = 128;  // Cells of 0.78 mm; the radius is 0.775 mm.
  CHECK(effects::unresolved_bodies(scene).starts_with("disks below a cell: 2 of "));
  scene.field().cells = 130;
  CHECK_EQ(effects::unresolved_bodies(scene), "");
  scene.field().cells = 64;
  scene.field().method = &multipole_method();
  CHECK_EQ(effects::unresolved_bodies(scene), "");
}

}  // namespace mechanics_summary_test
