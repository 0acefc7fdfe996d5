// Tables of computation and output of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "solvers/error.hpp"
#include "solvers/network/resistor.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace tables {
namespace {

using namespace ranges;

constexpr Range times{.low = smallest_size};

Table minimize() {
  return {
      .path = "minimize",
      .help = "Method and tolerances of the minimization that brings particles with effects.soft_repulsion to rest.",
      .keys = {
          {.name = "method",
           .target = [](Draft& d) { return &d.scene.minimize.method; },
           .help = "minimization method. lbfgs-newton: limited-memory BFGS until the contacts no longer change, then "
                   "Newton's method with conjugate gradients; lbfgs, newton-cg: only one of these two; fire: inertial "
                   "relaxation; gradient-descent: small constant steps down the gradient, which end in the minimum of "
                   "the gradient flow. Other methods may end in other minima"},
          {.name = "force_tolerance",
           .target = [](Draft& d) { return &d.scene.minimize.force_tolerance; },
           .range = {.low = 1e-15, .high = 1, .high_itself = false},  // smaller values are below rounding
           .help = "force tolerance: the run ends when the net force on every particle is at most this value, in units "
                   "of effects.soft_repulsion.stiffness (an energy, in J) over the mean diameter"},
          {.name = "max_iterations",
           .target = [](Draft& d) { return &d.scene.minimize.max_iterations; },
           .range = {.low = 0, .high = 1e12},
           .help = "largest number of iterations of the minimization in a run"},
          {.name = "step",
           .target = [](Draft& d) { return &d.scene.minimize.step; },
           .range = positive,
           .help = "for gradient-descent: ratio of the displacement of a step to the force, in units of the mean "
                   "diameter squared over effects.soft_repulsion.stiffness (an energy, in J)"},
          {.name = "record_every",
           .target = [](Draft& d) { return &d.scene.minimize.record_every; },
           .range = not_negative,
           .help = "number of iterations of the minimization between two recorded frames; 0: frames at the iterations "
                   "0, 1, 2, 3, 4, 6, 8, 11, 16, ..., and the last"},
          {.name = "threads",
           .target = [](Draft& d) { return &d.scene.minimize.threads; },
           .range = {.low = 0, .high = 1024},
           .help = "number of threads of the minimization, without effect on the result; 0: one per core, fewer for "
                   "few particles"},
      }};
}

Table compression() {
  const std::string one = "; only one of pressure, filling and excess is allowed";
  return {
      .path = "compression",
      .help =
          "Loads of a packing, one frame each: the domain changes its size in small steps, and the particles come "
          "to rest after each (O'Hern et al. 2003). Needs effects.soft_repulsion.",
      .keys = {
          {.name = "pressure",
           .target = [](Draft& d) { return &d.scene.compression.pressure; },
           .unit = "Pa",
           .range = positive,
           .computed_default = "none",
           .help = "list of pressures, one for each load, in Pa (in two dimensions N/m): of the plate, or the mean of "
                   "all directions" +
                   one},
          {.name = "filling",
           .target = [](Draft& d) { return &d.scene.compression.filling; },
           .range = {.low = 0, .high = 1, .low_itself = false},
           .computed_default = "none",
           .help = "list of packing fractions, one for each load: area or volume of the particles over that of the "
                   "domain, overlaps counted twice" +
                   one},
          {.name = "excess",
           .target = [](Draft& d) { return &d.scene.compression.excess; },
           .range = {.low = 0, .high = 1, .low_itself = false},
           .computed_default = "none",
           .help = "list of packing fractions above that at jamming; the first load is the jammed packing, with a "
                   "pressure of 1e-6 stiffness / diameter^dimension, and each number another load" +
                   one},
          {.name = "plate",
           .target = [](Draft& d) { return &d.scene.compression.plate; },
           .texts = {"right", "top", "back"},
           .computed_default = "none: all sides move, and the domain keeps its shape",
           .help = "side that moves as a plate while the others stay"},
          {.name = "step",
           .target = [](Draft& d) { return &d.scene.compression.step; },
           .range = {.low = 1e-6, .high = 0.1},
           .help = "largest change of the packing fraction between two minimizations"},
          {.name = "tolerance",
           .target = [](Draft& d) { return &d.scene.compression.tolerance; },
           .range = {.low = 1e-6, .high = 0.1},
           .help = "relative error of the pressure of a load"},
      }};
}

AtChoice field_method() {
  AtChoice at;
  for (const FieldMethodKind* method : field_methods()) at.names.push_back(method->name);
  at.name = [](Draft& d) { return d.field.method ? d.field.method->name : std::string(); };
  at.set = [](Draft& d, const std::string& name) { d.field.method = find_field_method(name); };
  return at;
}

/// Describes the field methods, as in "cut-cell: finite volumes; multipole: ..."
std::string methods_in_words() {
  std::vector<std::string> words;
  for (const FieldMethodKind* method : field_methods()) words.push_back(method->name + ": " + method->help);
  return fmt::format("{}", fmt::join(words, "; "));
}

/// Describes default tolerances: `usual` for the first method, then "1e-10 of multipole, ..." for the others.
std::string default_tolerances(const std::string& usual, double FieldTolerances::*which) {
  std::vector<std::string> others;
  for (const FieldMethodKind* method : field_methods())
    if (method != field_methods().front()) {
      std::string digits = fmt::format("{:g}", method->tolerance.*which);
      if (const auto zero = digits.find("e-0"); zero != std::string::npos) digits.erase(zero + 2, 1);
      others.push_back(digits + " of " + method->name);
    }
  return fmt::format("{}; {}", usual, fmt::join(others, ", "));
}

std::vector<Key> field_accuracy() {
  return {
      {.name = "accuracy",
       .target = [](Draft& d) { return &d.field.accuracy; },
       .range = {.low = 1e-12, .high = 0.1},
       .computed_default = "none; cells and tolerances count",
       .help = "bound on the relative errors of the field, from which cells, tolerances and, unless given, the method "
               "are chosen. Errors of potentials are relative to the largest potential difference (of spheres without "
               "walls, also from infinity). Errors of charges, also of the charge through resistors, are relative to "
               "the largest, and errors of forces on conductors to the largest. Forces below 1e-11 of eps V^2, with "
               "the permittivity eps and the largest potential difference V, count as rounding. Errors are measured: "
               "`solve` refuses an accuracy that it cannot reach. A run makes the choice at its start. In the plane "
               "it does so for gaps down to effects.contact_discharge.contact_distance, and checks the choice at "
               "checkpoints"},
      {.name = "method",
       .target = field_method(),
       .computed_default = "\"cut-cell\"; in three dimensions \"spheres\"",
       .help = methods_in_words()},
      {.name = "cells",
       .target = [](Draft& d) { return &d.field.options.cells; },
       .range = {.low = 8, .high = most_cells},
       .help = "number of square grid cells along the domain's longer side; the method multipole uses the grid for "
               "pictures only"},
      {.name = "tolerance",
       .target = [](Draft& d) { return &d.field.tolerance; },
       .range = accuracy,
       .computed_default = default_tolerances("1e-8", &FieldTolerances::single),
       .help = "bound on the relative error of a field that is solved once, for conductors at rest. cut-cell: in the "
               "energy norm, relative to the solution's; multipole and spheres: of potentials, charges and forces, "
               "each relative to the largest; relaxation: of the charges of groups"},
      {.name = "moving_tolerance",
       .target = [](Draft& d) { return &d.field.moving_tolerance; },
       .range = accuracy,
       .computed_default = default_tolerances(
           "1e-4 where mechanics.position_tolerance is 1e-3 of the smallest radius, with its square below, from "
           "1e-5 to 1e-4; 1e-5 with a circuit, coupling = \"monolithic\" or integrator = \"euler\"",
           &FieldTolerances::moving),
       .help = "bound on the relative error of each field solve of a run, in which the conductors move; the error is "
               "defined as for tolerance"},
  };
}

std::vector<Key> field_solvers() {
  return {
      {.name = "device",
       .target = [](Draft& d) { return &d.field.options.device; },
       .help = "device of the field solver of cut-cell; cpu: the processor; cuda: a GPU; --device on the command line "
               "has precedence"},
      {.name = "threads",
       .target = [](Draft& d) { return &d.field.options.threads; },
       .range = {.low = 0, .high = 1024},
       .help =
           "number of threads of the field methods cut-cell and spheres, without effect on the result. 0: one per "
           "core, but fewer on small grids of cut-cell, one in each of several processes (mpirun), and one for fewer "
           "than 48 spheres"},
      {.name = "boundary_stencil",
       .target = [](Draft& d) { return &d.field.options.links; },
       .help = "formula for the conductance between a grid cell and the surface of a disk. log-fitted: exact for a "
               "logarithmic potential; plain: exact for a linear one; aperture: first order, for comparison "
               "(linear_solver = \"assembled\")",
       .old_name = "links"},
      {.name = "linear_solver",
       .target = [](Draft& d) { return &d.field.options.linear_solver; },
       .help = "solver of the linear equations of cut-cell. multigrid: matrix-free, the fastest; assembled: assembled "
               "matrix, with any preconditioner of PETSc"},
      {.name = "relaxation_eta",
       .target = [](Draft& d) { return &d.field.relaxation_eta; },
       .unit = "V m/C",
       .range = positive,
       .computed_default = "chosen by the solver",
       .help = "for the method relaxation: step eta of its gradient descent from charges to potentials, in V m/C, the "
               "change of a conductor's potential over the error of its charge per length (Stephenson 2018, eq. 6.30)"},
  };
}

Table field() {
  return {.path = "field",
          .help = "Method, resolution and accuracy of the electric field, from which the forces on conductors follow.",
          .keys = joined({field_accuracy(), field_solvers()})};
}

std::vector<Key> integrators() {
  return {
      {.name = "integrator",
       .target = [](Draft& d) { return &d.scene.mechanics.integrator; },
       .computed_default = "\"cvode\"; \"multirate\" of grains",
       .help =
           "integrator of the equations of motion. For conductors: cvode: implicit, error-controlled, contacts located "
           "as events; euler: explicit (Stephenson 2018, eq. 6.7). For grains: multirate: charges act as impulses, and "
           "contacts have substeps between these; verlet: with predicted velocities; gear, gear-printed: Gear's of "
           "order 6, corrected and as printed in Singh 2019; cvode: the reference, for few grains"},
      {.name = "coupling",
       .target = [](Draft& d) { return &d.scene.mechanics.coupling; },
       .help = "coupling of field and motion. split: the field is solved between error-controlled steps and "
               "extrapolated over them; monolithic: the field is solved in each evaluation of the forces"},
      {.name = "predictor",
       .target = [](Draft& d) { return &d.scene.mechanics.predictor; },
       .help = "true: with coupling split, a coarser grid predicts the change of the field between two field "
               "solves. This needs a scene in two dimensions without a circuit (sources of different potentials, "
               "leakage or resistors). The grid must resolve the conductors and be at least four times coarser"},
  };
}

std::vector<Key> conductor_steps() {
  return {
      {.name = "relative_tolerance",
       .target = [](Draft& d) { return &d.scene.mechanics.relative_tolerance; },
       .range = {.low = 1e-15, .high = 1, .high_itself = false},  // smaller values are below rounding
       .computed_default = "1e-6; 1e-13 of grains",
       .help =
           "for the integrator cvode: bound on the error in a step, relative to the smallest radius for positions and "
           "to itself for a momentum; for grains, relative to each component plus 1 in reduced units"},
      {.name = "position_tolerance",
       .target = [](Draft& d) { return &d.position_tolerance; },
       .unit = "m",
       .range = positive,
       .computed_default = "1e-3 * the smallest radius",
       .help = "bound on the error of positions in a coupling step (the interval between two field solves), in m; at "
               "least 1e-9 of the smallest radius. Divided by that radius it also bounds the error of the charge "
               "through resistors per step, relative to the largest charge; field.accuracy may reduce that bound"},
      {.name = "largest_step",
       .target = [](Draft& d) { return &d.largest_step; },
       .unit = "s",
       .range = times,
       .computed_default = "output.every",
       .help = "largest coupling step, which is the interval between two field solves, in s"},
      {.name = "fix_z",
       .target = [](Draft& d) { return &d.scene.mechanics.fix_z; },
       .help = "true, in three dimensions only: conductors lie on a support and have a constant z. The support "
               "balances forces along z, which a run does not contain",
       .old_name = "keep_height"},
      {.name = "euler_step",
       .target = [](Draft& d) { return &d.scene.mechanics.euler_step; },
       .unit = "s",
       .range = positive,
       .help = "largest time step of the integrator euler, in s; the time between two field solves is divided into "
               "equal steps"},
      {.name = "euler_field_step",
       .target = [](Draft& d) { return &d.scene.mechanics.euler_field_step; },
       .unit = "s",
       .range = positive,
       .help = "largest time between two field solves of the integrator euler, in s; the time between two frames is "
               "divided into equal parts"},
  };
}

std::vector<Key> grain_steps() {
  return {
      {.name = "step",
       .target = [](Draft& d) { return &d.scene.mechanics.step; },
       .unit = "t0",
       .range = positive,
       .computed_default = "multirate: from effects.coulomb.accuracy, without any force except contacts as long as a "
                           "list of near pairs, or "
                           "0.05; cvode: 0.05; verlet: 0.005; gear: 0.0015",
       .help =
           "longest step of the motion of grains, in reduced units (t0). multirate: the forces of charges are "
           "constant over it, and it is shorter if the fastest grain would fly farther than about .2 d0; verlet and "
           "gear: it must resolve the shortest contact"},
      {.name = "contact_substeps",
       .target = [](Draft& d) { return &d.scene.mechanics.contact_steps; },
       .range = {.low = 4, .high = 1e4},
       .computed_default = "from effects.coulomb.accuracy: 16 for 1e-3, 50 for 1e-4; 16 without. Twice as many with "
                           "friction, adhesion, walls or several materials",
       .help = "for multirate: number of substeps in the shortest possible contact, or in the damping time if that is "
               "shorter; with n substeps, at least 16, the energy of a contact has a relative error of about "
               "1 / (4 n^2), and 1 / n^2 with friction, adhesion, walls or several materials",
       .old_name = "contact_steps"},
      {.name = "threads",
       .target = [](Draft& d) { return &d.scene.mechanics.threads; },
       .range = {.low = 0, .high = 1024},
       .help = "number of threads of the motion of grains, without effect on the result; 0: one per core, fewer for "
               "few grains"},
  };
}

Table mechanics() {
  return {.path = "mechanics",
          .help = "Integrator, steps and tolerances of the motion.",
          .keys = joined({integrators(), conductor_steps(), grain_steps()})};
}

Table network() {
  Table table = {.path = "network",
                 .help =
                     "Network of resistors between particles in contact, computed by `lichtenberg network` from a "
                     "packing's result file.",
                 .keys = {
                     {.name = "model",
                      .target = [](Draft& d) { return &d.scene.network.model; },
                      .computed_default = "both models",
                      .help = "nodes of the resistor network. particle: the particles, with one resistor per contact; "
                              "contact: the contacts, with resistors between all contacts of a particle"},
                     {.name = "terminals",
                      .target = [](Draft& d) { return &d.scene.network.between; },
                      .help = "electrodes between which the network's resistance is computed, the first at 0 V: names "
                              "of walls or numbers of particles",
                      .old_name = "between"},
                     {.name = "resistor",
                      .target = [](Draft& d) { return &d.scene.network.resistor; },
                      .computed_default = "\"constant\", of 1 Ohm",
                      .help = "law of a resistor's resistance, with the keys that it needs in parentheses:"},
                 }};
  Key& resistor = table.keys.back();
  for (const network::ResistorModel& model : network::resistor_models()) {
    resistor.texts.push_back(model.name);
    resistor.help += fmt::format(" {} ({}), {};", model.name, fmt::join(model.needs, ", "), model.help);
  }
  resistor.help.back() = '.';
  const auto add = [&](const char* name, KeyTarget target) {
    const auto& entry =
        *std::ranges::find(network::parameter_entries(), std::string_view(name), &network::ParameterEntry::name);
    table.keys.push_back({.name = name,
                          .target = target,
                          .unit = entry.unit,
                          .range = positive,
                          .computed_default = "none",
                          .help = entry.help});
  };
  add("resistance", [](Draft& d) { return &d.scene.network.parameters.resistance; });
  add("resistance_per_length", [](Draft& d) { return &d.scene.network.parameters.resistance_per_length; });
  add("sheet_resistance", [](Draft& d) { return &d.scene.network.parameters.sheet_resistance; });
  add("resistivity", [](Draft& d) { return &d.scene.network.parameters.resistivity; });
  add("contact_radius", [](Draft& d) { return &d.scene.network.parameters.contact_radius; });
  table.keys.back().old_name = "spot";
  add("film_resistance", [](Draft& d) { return &d.scene.network.parameters.film_resistance; });
  add("elastic_modulus", [](Draft& d) { return &d.scene.network.parameters.elastic_modulus; });
  add("hardness", [](Draft& d) { return &d.scene.network.parameters.hardness; });
  add("spot_radius", [](Draft& d) { return &d.scene.network.parameters.spot_radius; });
  return table;
}

Table output() {
  return {.path = "output",
          .help = "Files that a run writes, and the intervals at which it writes them.",
          .keys = {
              {.name = "file",
               .target = [](Draft& d) { return &d.output_file; },
               .computed_default = "the scene file's name, in the working directory, with .h5",
               .help = "path of the result file"},
              {.name = "every",
               .target = [](Draft& d) { return &d.scene.output.every; },
               .unit = "s",
               .range = positive,
               .help = "simulated time between two recorded frames, in s"},
              {.name = "checkpoint_every",
               .target = [](Draft& d) { return &d.scene.output.checkpoint_every; },
               .range = {.low = 1, .high = 1e9},
               .help = "number of frames between two checkpoints, from which a run can be resumed"},
              {.name = "field",
               .target = [](Draft& d) { return &d.scene.output.field; },
               .help = "precision in which the potential of the last frame is stored. single: four bytes per grid cell "
                       "before compression; double: eight bytes; none: the potential is not stored"},
              {.name = "picture",
               .target = [](Draft& d) { return &d.scene.output.picture; },
               .help = "true: a picture of the final state is drawn at the end of the run"},
          }};
}

Table stop() {
  return {
      .path = "stop",
      .help = "Conditions at which a run ends: it ends when the first of them is met.",
      .keys = {
          {.name = "time",
           .target = [](Draft& d) { return &d.scene.stop.time; },
           .unit = "s",
           .range = times,
           .help = "simulated time at which the run ends, counted from its start and including stages of "
                   "equilibration, in s"},
          {.name = "stationary",
           .target = [](Draft& d) { return &d.scene.stop.stationary; },
           .help = "true: the run also ends when all conductors are connected to a fixed potential (an electrode or "
                   "a [[group]]) and forces and speeds of movable ones are negligible (Stephenson 2018, eq. 7.1)"},
          {.name = "force",
           .target = [](Draft& d) { return &d.scene.stop.force; },
           .range = accuracy,
           .help = "fraction of the run's largest force, and of its largest speed, below which forces and speeds "
                   "of conductors are negligible for stop.stationary"},
      }};
}

}  // namespace
}  // namespace tables

std::vector<Table> tables_of_the_computation() {
  return {tables::minimize(), tables::compression(), tables::field(), tables::mechanics(),
          tables::network(),  tables::output(),      tables::stop()};
}

namespace {

std::vector<Named<Integrator>>& listed_integrators() {
  static std::vector<Named<Integrator>> all;
  if (all.empty())
    for (const IntegratorKind* kind : integrators::all) all.push_back({*kind, kind->name});
  return all;
}

}  // namespace

const Named<Integrator>* IntegratorList::begin() const { return listed_integrators().data(); }
const Named<Integrator>* IntegratorList::end() const { return begin() + listed_integrators().size(); }

void list_integrator(const IntegratorKind& kind) {
  const std::optional<Integrator> known = value_of<Integrator>(kind.name);
  if (known && &known->kind() != &kind)
    throw InputError(fmt::format("the integrator \"{}\" exists already: names must differ", kind.name));
  if (!known) listed_integrators().push_back({kind, kind.name});
}

std::string names_of(bool IntegratorKind::*property) {
  std::vector<std::string> names;
  for (const auto& [integrator, name] : values_named<Integrator>)
    if (integrator.kind().*property) names.emplace_back(name);
  return quoted(names);
}

}  // namespace lichtenberg
