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
  return {.path = "minimize",
          .help = "Method that brings particles with effects.soft_repulsion to rest.",
          .keys = {
              {.name = "method",
               .target = [](Draft& d) { return &d.scene.minimize.method; },
               .help = "lbfgs-newton: limited-memory BFGS until the contacts no longer change, then Newton's method "
                       "with conjugate gradients; lbfgs, newton-cg: only one of the two; fire: inertial relaxation; "
                       "gradient-descent: small constant steps down the gradient, which end in the minimum of the "
                       "gradient flow. Other methods may end in other minima"},
              {.name = "force_tolerance",
               .target = [](Draft& d) { return &d.scene.minimize.force_tolerance; },
               .range = {.low = 1e-15, .high = 1, .high_itself = false},  // smaller values are below rounding
               .help = "the run ends when no net force on a particle exceeds this value, in units of stiffness over "
                       "the mean diameter"},
              {.name = "max_iterations",
               .target = [](Draft& d) { return &d.scene.minimize.max_iterations; },
               .range = {.low = 0, .high = 1e12},
               .help = "largest number of iterations of a run"},
              {.name = "step",
               .target = [](Draft& d) { return &d.scene.minimize.step; },
               .range = positive,
               .help = "for gradient-descent: length of a step over the force, in units of the mean diameter squared "
                       "over stiffness"},
              {.name = "record_every",
               .target = [](Draft& d) { return &d.scene.minimize.record_every; },
               .range = not_negative,
               .help = "iterations between two frames; 0: at 0, 1, 2, 3, 4, 6, 8, 11, 16, ..., and the last"},
              {.name = "threads",
               .target = [](Draft& d) { return &d.scene.minimize.threads; },
               .range = {.low = 0, .high = 1024},
               .help = "number of threads, without effect on the result; 0: one per core, fewer for few particles"},
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
       .help =
           "bound on relative errors, which chooses cells, tolerances and, unless given, the method. Errors are those "
           "of potentials over the largest potential difference (of spheres without walls, also from infinity), of "
           "charges over the largest (also of the charge through resistors), and of forces on conductors over the "
           "largest. Forces below 1e-11 of eps V^2, V being the largest potential difference, count as rounding. "
           "Errors are measured: `solve` refuses an accuracy that it cannot reach. A run makes the choice at its "
           "start, in the plane for gaps down to contact_discharge's, and checks it at checkpoints"},
      {.name = "method",
       .target = field_method(),
       .computed_default = "\"cut-cell\"; in three dimensions \"spheres\"",
       .help = methods_in_words()},
      {.name = "cells",
       .target = [](Draft& d) { return &d.field.options.cells; },
       .range = {.low = 8, .high = most_cells},
       .help = "number of square cells along the domain's longer side; multipole uses them for pictures only"},
      {.name = "tolerance",
       .target = [](Draft& d) { return &d.field.tolerance; },
       .range = accuracy,
       .computed_default = default_tolerances("1e-8", &FieldTolerances::single),
       .help =
           "error of a single solve. cut-cell: in the energy norm, relative to the solution's; multipole and spheres: "
           "of potentials, charges and forces, relative to the largest; relaxation: of the groups' charges"},
      {.name = "moving_tolerance",
       .target = [](Draft& d) { return &d.field.moving_tolerance; },
       .range = accuracy,
       .computed_default = default_tolerances(
           "1e-4 where mechanics.position_tolerance is 1e-3 of the smallest radius, with its square below, from "
           "1e-5 to 1e-4; 1e-5 with a circuit, coupling = \"monolithic\" or integrator = \"euler\"",
           &FieldTolerances::moving),
       .help = "tolerance of the solves of a moving scene"},
  };
}

std::vector<Key> field_solvers() {
  return {
      {.name = "device",
       .target = [](Draft& d) { return &d.field.options.device; },
       .help = "device of the cut-cell solver; cpu: the processor; cuda: a GPU; --device on the command line has "
               "precedence"},
      {.name = "threads",
       .target = [](Draft& d) { return &d.field.options.threads; },
       .range = {.low = 0, .high = 1024},
       .help = "number of threads of cut-cell and spheres, without effect on the result; 0: one per core, fewer on "
               "small grids"},
      {.name = "boundary_stencil",
       .target = [](Draft& d) { return &d.field.options.links; },
       .help = "conductance from a cell to a disk; log-fitted: exact for a logarithmic potential; plain: for a linear "
               "one; aperture: first order, for comparison (linear_solver = \"assembled\")",
       .old_name = "links"},
      {.name = "linear_solver",
       .target = [](Draft& d) { return &d.field.options.linear_solver; },
       .help = "multigrid: matrix-free, the fastest; assembled: any preconditioner of PETSc"},
      {.name = "relaxation_eta",
       .target = [](Draft& d) { return &d.field.relaxation_eta; },
       .unit = "V m/C",
       .range = positive,
       .computed_default = "chosen by the solver",
       .help = "step of the gradient descent (D 6.30)"},
  };
}

Table field() {
  return {
      .path = "field", .help = "How the potential is computed.", .keys = joined({field_accuracy(), field_solvers()})};
}

std::vector<Key> integrators() {
  return {
      {.name = "integrator",
       .target = [](Draft& d) { return &d.scene.mechanics.integrator; },
       .computed_default = "\"cvode\"; \"multirate\" of grains",
       .help = "cvode: implicit, error-controlled, contacts located as events; euler: explicit (D 6.7). For grains: "
               "multirate: charges act as impulses, and contacts have substeps between these; verlet: with predicted "
               "velocities; gear, gear-printed: Gear's of order 6, corrected and as printed in G; cvode: the "
               "reference, for few grains"},
      {.name = "coupling",
       .target = [](Draft& d) { return &d.scene.mechanics.coupling; },
       .help = "split: field extrapolated over error-controlled steps; monolithic: solved in each evaluation"},
      {.name = "predictor",
       .target = [](Draft& d) { return &d.scene.mechanics.predictor; },
       .help = "with coupling split: use a coarser grid that resolves the conductors between field solves"},
  };
}

std::vector<Key> conductor_steps() {
  return {
      {.name = "relative_tolerance",
       .target = [](Draft& d) { return &d.scene.mechanics.relative_tolerance; },
       .range = {.low = 1e-15, .high = 1, .high_itself = false},  // smaller values are below rounding
       .computed_default = "1e-6; 1e-13 of grains",
       .help = "error of positions and momenta per step of the integrator; for grains only of cvode"},
      {.name = "position_tolerance",
       .target = [](Draft& d) { return &d.position_tolerance; },
       .unit = "m",
       .range = positive,
       .computed_default = "1e-3 * the smallest radius",
       .help = "largest error of positions in a coupling step; at least 1e-9 of the smallest radius. Divided by that "
               "radius it also bounds the error of the charge through resistors per step, relative to the largest "
               "charge; field.accuracy may reduce that bound"},
      {.name = "largest_step",
       .target = [](Draft& d) { return &d.largest_step; },
       .unit = "s",
       .range = times,
       .computed_default = "output.every",
       .help = "largest coupling step"},
      {.name = "fix_z",
       .target = [](Draft& d) { return &d.scene.mechanics.fix_z; },
       .help = "in three dimensions: conductors lie on a support and have a constant z; the support balances forces "
               "along z, which a run does not contain",
       .old_name = "keep_height"},
      {.name = "euler_step",
       .target = [](Draft& d) { return &d.scene.mechanics.euler_step; },
       .unit = "s",
       .range = positive,
       .help = "time step of euler"},
      {.name = "euler_field_step",
       .target = [](Draft& d) { return &d.scene.mechanics.euler_field_step; },
       .unit = "s",
       .range = positive,
       .help = "time between two field solves of euler"},
  };
}

std::vector<Key> grain_steps() {
  return {
      {.name = "step",
       .target = [](Draft& d) { return &d.scene.mechanics.step; },
       .unit = "t0",
       .range = positive,
       .computed_default = "multirate: from effects.coulomb.accuracy, or 0.05; verlet: 0.005; gear: 0.0015",
       .help = "for grains: the longest step. multirate keeps the forces of charges constant over it and takes shorter "
               "steps if the fastest grain would fly farther than .2 d0; steps of verlet and gear must resolve the "
               "shortest contact"},
      {.name = "contact_substeps",
       .target = [](Draft& d) { return &d.scene.mechanics.contact_steps; },
       .range = {.low = 4, .high = 1e4},
       .computed_default = "from effects.coulomb.accuracy: 16 for 1e-3, 50 for 1e-4; 16 without",
       .help = "for multirate: substeps in the shortest possible contact, or in the damping time if that is shorter; "
               "with n substeps the energy of a contact has a relative error of about 1 / (4 n^2)",
       .old_name = "contact_steps"},
      {.name = "threads",
       .target = [](Draft& d) { return &d.scene.mechanics.threads; },
       .range = {.low = 0, .high = 1024},
       .help = "number of threads, without effect on the result; 0: one per core, fewer for few grains"},
  };
}

Table mechanics() {
  return {.path = "mechanics",
          .help = "How the motion is computed.",
          .keys = joined({integrators(), conductor_steps(), grain_steps()})};
}

Table network() {
  Table table = {
      .path = "network",
      .help = "Resistors between particles in contact, for `lichtenberg network` on a packing's result file.",
      .keys = {
          {.name = "model",
           .target = [](Draft& d) { return &d.scene.network.model; },
           .computed_default = "both models",
           .help = "nodes of the network; particle: the particles; contact: the contacts"},
          {.name = "terminals",
           .target = [](Draft& d) { return &d.scene.network.between; },
           .help = "electrodes, the first at 0 V: names of walls or numbers of particles",
           .old_name = "between"},
          {.name = "resistor",
           .target = [](Draft& d) { return &d.scene.network.resistor; },
           .computed_default = "\"constant\", of 1 Ohm",
           .help = "model of a resistor, with the parameters that it needs:"},
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
  return table;
}

Table output() {
  return {.path = "output",
          .help = "Output of a run.",
          .keys = {
              {.name = "file",
               .target = [](Draft& d) { return &d.output_file; },
               .computed_default = "the scene file's name, in the working directory, with .h5",
               .help = "result file"},
              {.name = "every",
               .target = [](Draft& d) { return &d.scene.output.every; },
               .unit = "s",
               .range = positive,
               .help = "simulated time between two frames"},
              {.name = "checkpoint_every",
               .target = [](Draft& d) { return &d.scene.output.checkpoint_every; },
               .range = {.low = 1, .high = 1e9},
               .help = "frames between two checkpoints"},
              {.name = "field",
               .target = [](Draft& d) { return &d.scene.output.field; },
               .help = "stored potential of the last frame; single: in single precision, four bytes per cell before "
                       "compression; double: in double precision; none: not stored"},
              {.name = "picture",
               .target = [](Draft& d) { return &d.scene.output.picture; },
               .help = "draw the final state"},
          }};
}

Table stop() {
  return {.path = "stop",
          .help = "When a run ends: at whichever comes first.",
          .keys = {
              {.name = "time",
               .target = [](Draft& d) { return &d.scene.stop.time; },
               .unit = "s",
               .range = times,
               .help = "simulated time from the start, including a run's stages"},
              {.name = "stationary",
               .target = [](Draft& d) { return &d.scene.stop.stationary; },
               .help = "stop when all conductors are connected to an electrode and the forces are negligible (D 7.1)"},
              {.name = "force",
               .target = [](Draft& d) { return &d.scene.stop.force; },
               .range = accuracy,
               .help = "forces below this fraction of the run's largest force are negligible for stop.stationary"},
          }};
}

}  // namespace
}  // namespace tables

std::vector<Table> tables_of_the_computation() {
  return {tables::minimize(), tables::field(),  tables::mechanics(),
          tables::network(),  tables::output(), tables::stop()};
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
