#include "src/scene/grains.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "solvers/geometry/box.hpp"
#include "solvers/random.hpp"
#include "src/scene/charge_distribution.hpp"
#include "src/scene/contact_steps.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/ground.hpp"
#include "src/scene/placing.hpp"
#include "src/scene/schema.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {
namespace tables {
namespace {

using namespace ranges;

Table reference() {
  return {.path = "units",
          .help =
              "Makes the scene one of grains in reduced units. Without this table a scene with effects of grains is in "
              "SI, and the program chooses the scales (command explain). With it numbers are in units of these scales, "
              "even if their "
              "keys name another unit: lengths in d0, masses in m0, velocities in v0, charges in q0, times in t0 = d0 "
              "/ v0, energies and temperatures in m0 v0^2. Only the keys of this table and the keys young, "
              "viscosity and surface_energy of effects are in SI. The defaults are those of Singh 2019, table 5.3.",
          .open = [](Draft& d, int) { d.scene.reference.emplace(); },
          .keys =
              {
                  {.name = "length",
                   .target = [](Draft& d) { return &d.scene.reference->length; },
                   .unit = "m",
                   .range = positive,
                   .help = "unit of length d0, in m: the diameter of a grain"},
                  {.name = "mass",
                   .target = [](Draft& d) { return &d.scene.reference->mass; },
                   .unit = "kg",
                   .range = positive,
                   .help = "unit of mass m0, in kg: the mass of a grain"},
                  {.name = "velocity",
                   .target = [](Draft& d) { return &d.scene.reference->velocity; },
                   .unit = "m/s",
                   .range = positive,
                   .help = "unit of velocity v0, in m/s"},
                  {.name = "charge",
                   .target = [](Draft& d) { return &d.scene.reference->charge; },
                   .unit = "C",
                   .range = positive,
                   .help = "unit of charge q0, in C"},
              },
          .old_path = "reference"};
}

Table stage() {
  return {.path = "equilibration",
          .kind = Table::Kind::repeated,
          .help =
              "A stage of equilibration of grains with modified settings, before the run with all effects. Stages are "
              "sequential, in the order of the tables.",
          .open = [](Draft& d, int) { d.scene.stages.emplace_back(); },
          .keys =
              {
                  {.name = "duration",
                   .target = [](Draft& d) { return &d.scene.stages.back().duration; },
                   .unit = "t0",
                   .range = positive,
                   .required = true,
                   .help = "duration of the stage, in reduced units (t0)"},
                  {.name = "elastic",
                   .target = [](Draft& d) { return &d.scene.stages.back().elastic; },
                   .help = "true: in this stage contacts dissipate no energy and transfer no charge, and gas_drag and "
                           "uniform_force do not act"},
                  {.name = "stiffness",
                   .target = [](Draft& d) { return &d.scene.stages.back().stiffness; },
                   .range = {.low = 1,
                             .high = 1e15},  // overlaps scale as stiffness^(-2/5): down to 1e-7, far above rounding
                   .help = "factor by which this stage multiplies the contact stiffness, so that the fastest grains do "
                           "not overlap too deeply or pass through each other; dissipative contacts have an unchanged "
                           "restitution coefficient"},
                  {.name = "temperature",
                   .target = [](Draft& d) { return &d.scene.stages.back().temperature; },
                   .unit = "m0 v0^2",
                   .range = positive,
                   .computed_default = "none",
                   .help = "temperature to which all velocities are scaled at the end of the stage, in reduced units "
                           "(m0 v0^2)"},
              },
          .old_path = "stage"};
}

}  // namespace
}  // namespace tables

std::vector<Table> tables_of_grains() { return {tables::reference(), tables::stage()}; }

namespace {

/// Keys of [mechanics] that apply to conductors only.
constexpr const char* conductor_keys[] = {"coupling", "predictor",  "position_tolerance", "largest_step",
                                          "fix_z",    "euler_step", "euler_field_step"};

/// Throws InputError for a key of [mechanics] that the integrator of conductors does not read.
void check_keys(const Draft& draft) {
  const MechanicsOptions& mechanics = draft.scene.mechanics;
  const bool monolithic = &mechanics.kind() != &mechanics.integrator.kind();
  const auto check = [&](const std::string& key) {
    if (!mechanics.kind().reads(key))
      refuse_if_given(
          draft, "mechanics." + key,
          fmt::format("is not allowed with {}, where it has no effect: leave it out",
                      monolithic ? std::string("mechanics.coupling = \"monolithic\"")
                                 : fmt::format("mechanics.integrator = \"{}\"", name_of(mechanics.integrator))));
  };
  // contact_discharge uses position_tolerance to distinguish contacts, whatever the integrator.
  for (const std::string key : conductor_keys)
    if (key != "position_tolerance" || !draft.scene.effects.has("contact_discharge")) check(key);
  check("relative_tolerance");
}

void check_conductors(const Draft& draft) {
  for (const Effects::Entry& entry : draft.scene.effects)
    if (entry.kind->grains)
      refuse_effect(draft, entry.kind->name, "the table [units], which makes the scene one of grains");
  for (const char* key :
       {"equilibration", "population.temperature", "population.velocity_spread", "population.charge_distribution",
        "population.charge_exponent", "mechanics.step", "mechanics.contact_substeps", "mechanics.threads",
        "conductor.angular_velocity", "population.rotational_temperature", "conductor.relative_permittivity",
        "population.relative_permittivity", "conductor.relative_density", "population.relative_density",
        "conductor.relative_stiffness", "population.relative_stiffness", "conductor.relative_damping",
        "population.relative_damping"})
    refuse_if_given(draft, key,
                    "needs the table [units], which makes the scene one of grains: add it, or leave the key out");
  if (!draft.scene.mechanics.integrator->moves_conductors)
    refuse(draft.scene.path, draft.line("mechanics.integrator"),
           fmt::format("mechanics.integrator = \"{}\" needs the table [units], which makes the scene one of "
                       "grains: {} are allowed without",
                       name_of(draft.scene.mechanics.integrator), names_of(&IntegratorKind::moves_conductors)));
  check_keys(draft);
}

/// Throws InputError for keys that only integrators of conductors read, and for keys that the integrator of grains does
/// not read.
void check_mechanics(const Draft& draft) {
  for (const std::string key : conductor_keys)
    refuse_if_given(draft, "mechanics." + key,
                    "is not allowed in a scene of grains: it is for conductors; leave it out");
  const Integrator integrator = draft.scene.mechanics.integrator;
  if (!integrator->reads("relative_tolerance"))
    refuse_if_given(draft, "mechanics.relative_tolerance",
                    fmt::format("is not allowed with mechanics.integrator = \"{}\": of grains it is for \"cvode\"",
                                name_of(integrator)));
  if (const EffectKind* effect = surface_effect(draft.scene.effects);
      effect && draft.line("mechanics.integrator") > 0 && !integrator->has_surface_forces)
    refuse(
        draft.scene.path, draft.line("mechanics.integrator"),
        fmt::format("mechanics.integrator = \"{}\" is not allowed with effects.{}, whose forces it does not compute: "
                    "{} is allowed",
                    name_of(integrator), effect->name, names_of(&IntegratorKind::has_surface_forces)));
  if (!integrator->reads("contact_substeps"))
    refuse_if_given(
        draft, "mechanics.contact_substeps",
        fmt::format("is not allowed with mechanics.integrator = \"{}\": it is for \"multirate\"", name_of(integrator)));
}

/// Throws InputError for angular velocities of grains that do not rotate, or that have components in the plane of a
/// domain of two dimensions.
void check_rotation(const Draft& draft) {
  if (!draft.scene.effects.has("friction"))
    for (const char* key : {"conductor.angular_velocity", "population.rotational_temperature"})
      refuse_if_given(
          draft, key,
          "needs the table [effects.friction], without which grains do not rotate: add it, or leave the key "
          "out");
  for (const ConductorDraft& conductor : draft.conductors) {
    if (!conductor.angular_velocity) continue;
    const auto& [w, count] = *conductor.angular_velocity;
    if (count != 3 || (draft.scene.dimension() == 2 && (w.x != 0 || w.y != 0)))
      refuse(draft.scene.path, conductor.line,
             "conductor.angular_velocity must have three numbers, of which the first two are 0 in two dimensions");
  }
}

/// Throws InputError for sides of the domain that a scene of grains does not support.
void check_sides(const Draft& draft) {
  const Domain& domain = draft.scene.domain;
  for (int s = 0; s < 2 * draft.scene.dimension() && !domain.open; ++s) {
    const auto refuse_it = [&](const std::string& message) {
      const std::string key = fmt::format("domain.{}", side_names[s]);
      refuse(draft.scene.path, draft.line(draft.line(key) > 0 ? key : "domain"),
             fmt::format("{} = {} is not allowed {}", key, show(domain.sides[s]), message));
    };
    if (domain.sides[s].periodic) continue;
    if (domain.sides[s].potential != 0)
      refuse_it("in a scene of grains: a conducting side is grounded, { potential = 0 }");
    if (!draft.scene.effects.has("flat_walls"))
      refuse_it(
          "without the table [effects.flat_walls], with which grains meet walls: add it, or use \"periodic\" or "
          "domain.unbounded = true");
  }
}

}  // namespace

void check_grains(const Draft& draft) {
  if (!draft.scene.reference) return check_conductors(draft);
  for (const Effects::Entry& entry : draft.scene.effects)
    if (!entry.kind->grains)
      refuse(draft.scene.path, draft.line("effects." + entry.kind->name),
             fmt::format("effects.{} is not allowed with [units], which makes the scene one of grains: it is for "
                         "scenes of conductors or packings; leave one out",
                         entry.kind->name));
  for (const char* table : {"electrode", "wall", "group", "medium", "field", "minimize", "network"})
    refuse_if_given(draft, table, "is not allowed in a scene of grains, to which it does not apply: leave it out");
  if (draft.line("mechanics.integrator") > 0 && !draft.scene.mechanics.integrator->moves_grains)
    refuse(draft.scene.path, draft.line("mechanics.integrator"),
           fmt::format("mechanics.integrator = \"{}\" is not allowed in a scene of grains: {} are",
                       name_of(draft.scene.mechanics.integrator), names_of(&IntegratorKind::moves_grains)));
  if (!draft.scene.effects.has("induced_dipoles"))
    for (const char* key : {"conductor.relative_permittivity", "population.relative_permittivity"})
      refuse_if_given(
          draft, key,
          "needs the table [effects.induced_dipoles], without which grains have no dipoles: add it, or leave "
          "the key out");
  check_mechanics(draft);
  check_rotation(draft);
  check_sides(draft);
}

namespace {

/// Returns the default step (t0). For multirate it is infinite if an effect has a force accuracy, which then sets the
/// step, or if only contacts act. For other integrators it follows from the shortest contact of grains at T = 10 in a
/// stage with ten times the stiffness.
double default_step(const Scene& scene) {
  const IntegratorKind& integrator = scene.mechanics.integrator.kind();
  const bool any_step = least_in(scene, &StepLimits::force_accuracy) || only_contacts_act(scene);
  return integrator.takes_any_step && any_step ? INFINITY : integrator.usual_step;
}

/// Returns the default number of contact substeps, with which contacts have the same error as the most accurate forces.
int default_contact_steps(const Scene& scene) {
  return contact_steps_for(least_in(scene, &StepLimits::force_accuracy).value_or(usual_contact_accuracy) /
                           contact_error_factor(scene));
}

}  // namespace

double contact_error_factor(const Scene& scene) { return surface_key(scene).empty() ? 1 : 4; }

void fill_in_grains(Draft& draft) {
  Scene& scene = draft.scene;
  const auto is_given = [&](const char* key) { return draft.line(key) > 0; };
  if (!is_given("material.density")) scene.material.density = 6 / std::numbers::pi;  // mass 1 at diameter 1
  if (!is_given("mechanics.integrator")) scene.mechanics.integrator = Integrator::multirate;
  // Tolerance of a reference solution
  if (!is_given("mechanics.relative_tolerance")) scene.mechanics.relative_tolerance = 1e-13;
  if (!is_given("stop.time")) scene.stop.time = 150;
  if (!is_given("output.every")) scene.output.every = scene.stop.time / 100;
  scene.stop.stationary = false;
  for (PopulationDraft& population : draft.populations)
    if (!population.radius && population.radii.empty()) population.radius = Interval{0.5, 0.5};
  for (ConductorDraft& conductor : draft.conductors)
    if (conductor.angular_velocity) conductor.conductor.angular_velocity = conductor.angular_velocity->value;
}

void fill_in_steps(const Draft& draft, Scene& scene) {
  if (draft.line("mechanics.step") == 0) scene.mechanics.step = default_step(scene);
  if (draft.line("mechanics.contact_substeps") == 0) scene.mechanics.contact_steps = default_contact_steps(scene);
}

namespace {

void check_charges(const Draft& draft, const PopulationDraft& population) {
  const bool drawn = population.charge_distribution != ChargeDistribution::equal;
  const bool exponential = population.charge_distribution == ChargeDistribution::exponential_power;
  const auto refuse_it = [&](const std::string& message) {
    refuse(draft.scene.path, population.line,
           fmt::format("population.charge_distribution = \"{}\" {}", name_of(population.charge_distribution), message));
  };
  if (drawn && !(population.charge > 0)) refuse_it("needs population.charge, the width, greater than 0: add it");
  if (drawn && population.count == 1) refuse_it("needs more than one grain: the charges of all add up to 0");
  if (exponential && !population.charge_exponent) refuse_it("needs population.charge_exponent: add it");
  if (!exponential && population.charge_exponent)
    refuse_it("does not use population.charge_exponent, which is for \"exponential-power\": leave it out");
}

/// Throws InputError if a grain could be in contact with two images of another.
void check_shortest_side(const Draft& draft, const Scene& scene) {
  double shortest = INFINITY, largest = 0;
  for (int k = 0; k < scene.dimension(); ++k)
    if (scene.domain.sides[2 * k].periodic) shortest = std::min(shortest, scene.domain.size[k]);
  for (const Conductor& grain : scene.conductors) largest = std::max(largest, 2 * grain.radius);
  if (largest > shortest / 2)
    refuse(
        scene.path, draft.line("domain.size"),
        fmt::format(
            "domain.size = {:g} d0 along its shortest periodic side is not allowed with a grain of diameter {:g} d0: "
            "at least twice that is needed, or it would meet two images of another",
            shortest, largest));
}

/// Throws InputError for equilibration stages whose duration is lost in the rounding of time.
void check_stages(const Draft& draft) {
  constexpr double least = 1e-12;  // fraction of the end time: thousands of units in the last digit of time
  double end = 0;
  for (const Stage& stage : draft.scene.stages)
    if (end += stage.duration; stage.duration < least * end)
      refuse(draft.scene.path, draft.line("equilibration"),
             fmt::format(
                 "equilibration.duration = {:g} t0 is not allowed in a stage that ends at {:g} t0: it must be at least "
                 "{:g} times that, or its time is lost in rounding",
                 stage.duration, end, least));
}

/// Draws Gaussian velocities with zero total momentum for grains `first` to before `end`, and scales them to exactly
/// this temperature.
void set_temperature(Scene& scene, std::size_t first, std::size_t end, double temperature) {
  const int d = scene.dimension();
  const auto mass = [&](const Conductor& c) {
    return c.material.density * c.radius * c.radius * c.radius;
  };  // mass in arbitrary units
  Vec3 momentum{};
  double all = 0;
  for (std::size_t i = first; i < end; ++i) {
    Conductor& grain = scene.conductors[i];
    Random random({.seed = scene.seed, .purpose = RandomPurpose::population, .i = i});
    for (int k = 0; k < d; ++k) grain.velocity[k] = random.normal() / std::sqrt(mass(grain));
    momentum += mass(grain) * grain.velocity;
    all += mass(grain);
  }
  double energy = 0;
  for (std::size_t i = first; i < end; ++i) {
    Conductor& grain = scene.conductors[i];
    grain.velocity -= momentum / all;
    energy += 4.0 / 3.0 * std::numbers::pi * scene.material.density * mass(grain) * norm2(grain.velocity);
  }
  const double now = energy / (d * static_cast<double>(end - first));
  for (std::size_t i = first; i < end; ++i) scene.conductors[i].velocity *= now > 0 ? std::sqrt(temperature / now) : 0;
}

/// Returns the mean mass (m0) of grains `first` to before `end`.
double mean_mass(const Scene& scene, std::size_t first, std::size_t end) {
  double sum = 0;
  for (std::size_t i = first; i < end; ++i) {
    const Conductor& grain = scene.conductors[i];
    sum += grain.material.density * grain.radius * grain.radius * grain.radius;
  }
  return 4.0 / 3.0 * std::numbers::pi * scene.material.density * sum / static_cast<double>(end - first);
}

}  // namespace

void complete_grains(const Draft& draft, Scene& scene) {
  check_stages(draft);
  check_shortest_side(draft, scene);
  for (const PopulationDraft& population : draft.populations) check_charges(draft, population);
  const IntegratorKind& integrator = scene.mechanics.integrator.kind();
  if (integrator.most_grains > 0 && scene.conductors.size() > integrator.most_grains)
    refuse(scene.path, draft.line("mechanics.integrator"),
           fmt::format("mechanics.integrator = \"{}\" is not allowed with {} grains: it is for at most {}; "
                       "\"multirate\" is for more",
                       integrator.name, scene.conductors.size(), integrator.most_grains));
  std::size_t first = draft.conductors.size();
  for (const PopulationDraft& population : draft.populations) {
    const std::size_t end = first + population.count;
    const std::vector<double> charges = charges_of(population, scene.seed, first);
    for (std::size_t i = first; i < end; ++i) scene.conductors[i].charge = charges[i - first];
    if (population.temperature && population.velocity_spread)
      refuse(scene.path, population.line,
             "population.temperature and population.velocity_spread are both given: only one of them is allowed");
    if (population.temperature) set_temperature(scene, first, end, *population.temperature);
    if (const auto spread = population.velocity_spread)
      set_temperature(scene, first, end, *spread * *spread * mean_mass(scene, first, end));
    first = end;
  }
}

}  // namespace lichtenberg
