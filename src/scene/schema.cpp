#include "src/scene/schema.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/network/resistor.hpp"
#include "src/scene/value.hpp"

namespace lichtenberg {
namespace {

constexpr Range positive{.low = 0, .low_itself = false};
constexpr Range not_negative{.low = 0};
constexpr Range accuracy{.low = 0, .high = 1, .low_itself = false, .high_itself = false};

using enum Table::Kind;

Table top() {
  return {.help = "The scene as a whole.",
          .keys = {
              {.name = "title",
               .place = [](Draft& d) { return &d.scene.title; },
               .computed_default = "none",
               .help = "what pictures and summaries call the run"},
              {.name = "seed",
               .place = [](Draft& d) { return &d.seed; },
               .range = not_negative,
               .help = "of the random numbers that place the populations"},
          }};
}

Table domain() {
  const std::string side = "side of the domain: insulating (no field through it), or an electrode at a potential";
  return {.path = "domain",
          .kind = required,
          .help = "The rectangle [0, size x] x [0, size y] filled with fluid; with a third number a cuboid.",
          .keys = {
              {.name = "size",
               .place = [](Draft& d) { return &d.domain_size; },
               .unit = "m",
               .range = positive,
               .required = true,
               .help = "width and height; width, depth and height of a packing in three dimensions"},
              {.name = "left", .place = [](Draft& d) { return &d.scene.domain.sides[0]; }, .unit = "V", .help = side},
              {.name = "right", .place = [](Draft& d) { return &d.scene.domain.sides[1]; }, .unit = "V", .help = side},
              {.name = "bottom", .place = [](Draft& d) { return &d.scene.domain.sides[2]; }, .unit = "V", .help = side},
              {.name = "top", .place = [](Draft& d) { return &d.scene.domain.sides[3]; }, .unit = "V", .help = side},
          }};
}

Table medium() {
  return {.path = "medium",
          .help = "The fluid.",
          .keys = {
              {.name = "relative_permittivity",
               .place = [](Draft& d) { return &d.relative_permittivity; },
               .range = {.low = 1},
               .computed_default = "none; floating_conductors needs it or permittivity",
               .help = "permittivity in units of the vacuum's, 8.8541878128e-12 F/m"},
              {.name = "permittivity",
               .place = [](Draft& d) { return &d.permittivity; },
               .unit = "F/m",
               .range = positive,
               .computed_default = "from relative_permittivity",
               .help = "absolute permittivity; give this or relative_permittivity, not both"},
              {.name = "viscosity",
               .place = [](Draft& d) { return &d.viscosity; },
               .unit = "Pa s",
               .range = positive,
               .computed_default = "none; stokes_drag needs it",
               .help = "dynamic viscosity"},
              {.name = "depth",
               .place = [](Draft& d) { return &d.depth; },
               .unit = "m",
               .range = positive,
               .computed_default = "2 * the largest radius: a monolayer",
               .help = "turns charge, force and energy per metre of the two-dimensional field into C, N and J"},
              {.name = "temperature",
               .place = [](Draft& d) { return &d.scene.medium.temperature; },
               .unit = "K",
               .range = positive,
               .help = "turns dissipated power into entropy production, and does nothing else"},
          }};
}

Table material() {
  return {.path = "material",
          .help = "What the conductors are made of.",
          .keys = {
              {.name = "density",
               .place = [](Draft& d) { return &d.scene.material.density; },
               .unit = "kg/m^3",
               .range = positive,
               .help = "their masses are those of spheres; the default is steel"},
          }};
}

Table electrode() {
  return {.path = "electrode",
          .kind = repeated,
          .help = "A fixed conducting body at a given potential. It may reach beyond the domain, which cuts it.",
          .open = [](Draft& d, int line) { d.electrodes.push_back({.line = line}); },
          .keys = {
              {.name = "name",
               .place = [](Draft& d) { return &d.electrodes.back().name; },
               .computed_default = "the shape and a number, as in \"disk 1\"",
               .help = "its name in messages and results"},
              {.name = "shape",
               .place = [](Draft& d) { return &d.electrodes.back().shape; },
               .choices = {"disk", "half-disk", "bar", "ring"},
               .required = true,
               .help = "half-disk: a disk centred on a side of the domain; ring: conducting outside its circle"},
              {.name = "potential",
               .place = [](Draft& d) { return &d.electrodes.back().potential; },
               .unit = "V",
               .required = true,
               .help = "its potential, or that of the supply if there is a series resistance"},
              {.name = "series_resistance",
               .place = [](Draft& d) { return &d.electrodes.back().series_resistance; },
               .unit = "ohm",
               .range = positive,
               .computed_default = "none",
               .help = "resistor between the supply and the body, which starts without charge and whose potential "
                       "follows from the current"},
              {.name = "centre",
               .place = [](Draft& d) { return &d.electrodes.back().centre; },
               .unit = "m",
               .shapes = {"disk", "ring"},
               .help = "of the circle"},
              {.name = "radius",
               .place = [](Draft& d) { return &d.electrodes.back().radius; },
               .unit = "m",
               .range = positive,
               .shapes = {"disk", "half-disk", "ring"},
               .help = "of the circle"},
              {.name = "side",
               .place = [](Draft& d) { return &d.electrodes.back().side; },
               .choices = {"left", "right", "bottom", "top"},
               .shapes = {"half-disk"},
               .help = "side of the domain on which the centre lies"},
              {.name = "at",
               .place = [](Draft& d) { return &d.electrodes.back().at; },
               .unit = "m",
               .range = not_negative,
               .shapes = {"half-disk"},
               .help = "x of the centre (bottom, top) or y (left, right)"},
              {.name = "from",
               .place = [](Draft& d) { return &d.electrodes.back().from; },
               .unit = "m",
               .shapes = {"bar"},
               .help = "one end of the bar's axis"},
              {.name = "to",
               .place = [](Draft& d) { return &d.electrodes.back().to; },
               .unit = "m",
               .shapes = {"bar"},
               .help = "the other end; the ends are flat"},
              {.name = "width",
               .place = [](Draft& d) { return &d.electrodes.back().width; },
               .unit = "m",
               .range = positive,
               .shapes = {"bar"},
               .help = "across the axis"},
          }};
}

Table conductor() {
  return {.path = "conductor",
          .kind = repeated,
          .help = "A movable conductor: a disk to the field, a sphere to the mechanics.",
          .open = [](Draft& d, int line) { d.conductors.push_back({.line = line}); },
          .keys = {
              {.name = "position",
               .place = [](Draft& d) { return &d.conductors.back().position; },
               .unit = "m",
               .required = true,
               .help = "of the centre"},
              {.name = "radius",
               .place = [](Draft& d) { return &d.conductors.back().conductor.radius; },
               .unit = "m",
               .range = positive,
               .required = true,
               .help = "its radius"},
              {.name = "relative_resistivity",
               .place = [](Draft& d) { return &d.conductors.back().conductor.relative_resistivity; },
               .range = positive,
               .help = "by what its resistors in [network] resist more than the parameters there say"},
              {.name = "charge",
               .place = [](Draft& d) { return &d.conductors.back().charge; },
               .unit = "C",
               .computed_default = "0",
               .help = "charge at the start; not for a member of a group"},
              {.name = "velocity",
               .place = [](Draft& d) { return &d.conductors.back().conductor.velocity; },
               .unit = "m/s",
               .help = "velocity at the start"},
              {.name = "group",
               .place = [](Draft& d) { return &d.conductors.back().group; },
               .computed_default = "none",
               .help = "name of the [[group]] that it is wired to"},
          }};
}

Table wall() {
  return {.path = "wall",
          .kind = repeated,
          .help = "A flat wall without end, beside the sides of the domain. Needs effects.contact_potential.",
          .open = [](Draft& d, int line) { d.walls.push_back({.line = line}); },
          .keys = {
              {.name = "name",
               .place = [](Draft& d) { return &d.walls.back().name; },
               .computed_default = "\"wall\" and a number, as in \"wall 1\"",
               .help = "its name in messages and results"},
              {.name = "point",
               .place = [](Draft& d) { return &d.walls.back().point; },
               .unit = "m",
               .required = true,
               .help = "a point of it"},
              {.name = "normal",
               .place = [](Draft& d) { return &d.walls.back().normal; },
               .required = true,
               .help = "points to the particles' side; of any length but 0"},
          }};
}

Table group() {
  return {
      .path = "group",
      .kind = repeated,
      .help = "Conductors wired together: one potential, whether they touch or not. Give its charge or its potential.",
      .open = [](Draft& d, int line) { d.groups.push_back({.line = line}); },
      .keys = {
          {.name = "name",
           .place = [](Draft& d) { return &d.groups.back().name; },
           .required = true,
           .help = "what its conductors refer to"},
          {.name = "charge",
           .place = [](Draft& d) { return &d.groups.back().charge; },
           .unit = "C",
           .computed_default = "none",
           .help = "charge of all its conductors together; their potential floats"},
          {.name = "potential",
           .place = [](Draft& d) { return &d.groups.back().potential; },
           .unit = "V",
           .computed_default = "none",
           .help = "potential held from outside; the charge follows"},
      }};
}

Table population() {
  return {.path = "population",
          .kind = repeated,
          .help = "Conductors at random places, drawn uniformly one after the other, by default without overlap.",
          .open = [](Draft& d, int line) { d.populations.push_back({.line = line}); },
          .keys = {
              {.name = "count",
               .place = [](Draft& d) { return &d.populations.back().count; },
               .range = {.low = 1, .high = 1e6},
               .required = true,
               .help = "how many"},
              {.name = "radius",
               .place = [](Draft& d) { return &d.populations.back().radius; },
               .unit = "m",
               .range = positive,
               .computed_default = "none; needed unless radii are given",
               .help = "of all, or the interval from which each draws its own"},
              {.name = "radii",
               .place = [](Draft& d) { return &d.populations.back().radii; },
               .unit = "m",
               .range = positive,
               .computed_default = "none",
               .help = "in place of radius: radii that are taken in turn, and over again if count is larger"},
              {.name = "distribution",
               .place = [](Draft& d) { return &d.populations.back().distribution; },
               .choices = {"uniform", "normal", "lognormal"},
               .help = "of the radii in their interval, which truncates it"},
              {.name = "mean",
               .place = [](Draft& d) { return &d.populations.back().mean; },
               .unit = "m",
               .range = positive,
               .computed_default = "the middle of the interval",
               .help = "of normal before it is truncated; of lognormal the median"},
              {.name = "deviation",
               .place = [](Draft& d) { return &d.populations.back().deviation; },
               .range = positive,
               .computed_default = "none; needed for normal and lognormal",
               .help = "standard deviation: of normal over the mean, of lognormal that of the radius's logarithm"},
              {.name = "overlapping",
               .place = [](Draft& d) { return &d.populations.back().overlapping; },
               .help = "places are taken as they are drawn, overlapping or not; needs effects.contact_potential"},
              {.name = "relative_resistivity",
               .place = [](Draft& d) { return &d.populations.back().relative_resistivity; },
               .range = positive,
               .help = "by what its resistors in [network] resist more than the parameters there say"},
              {.name = "charge",
               .place = [](Draft& d) { return &d.populations.back().charge; },
               .unit = "C",
               .help = "of each at the start"},
              {.name = "min_gap",
               .place = [](Draft& d) { return &d.populations.back().min_gap; },
               .unit = "m",
               .range = not_negative,
               .help = "least gap from a surface to any other conductor, electrode or side of the domain"},
              {.name = "region",
               .place = [](Draft& d) { return &d.populations.back().region; },
               .unit = "m",
               .computed_default = "the whole domain",
               .help = "rectangle that they lie in"},
          }};
}

Table effects() {
  return {.path = "effects", .help = "An effect is in the run only if its table stands in the scene."};
}

Table floating_conductors() {
  return {.path = "effects.floating_conductors",
          .help = "Electrostatics: conductors with given charges, the potential between them, the forces (D 5.3).",
          .open = [](Draft& d, int) { d.scene.effects.floating_conductors.emplace(); }};
}

Table current_source() {
  return {.path = "effects.current_source",
          .help = "Every conductor is fed the same current, dQ/dt = current (D 5.5). Needs floating_conductors.",
          .open = [](Draft& d, int) { d.scene.effects.current_source.emplace(); },
          .keys = {
              {.name = "current",
               .place = [](Draft& d) { return &d.scene.effects.current_source->current; },
               .unit = "A",
               .required = true,
               .help = "into each conductor"},
          }};
}

Table stokes_drag() {
  return {.path = "effects.stokes_drag",
          .help = "Drag of a sphere in the fluid, F = -6 pi viscosity R v (D 5.8). Needs medium.viscosity.",
          .open = [](Draft& d, int) { d.scene.effects.stokes_drag.emplace(); }};
}

/// The elastic constants of the contact that `contact` finds in a draft.
template <class Contact>
std::vector<Key> elastic_constants(Contact) {
  return {
      {.name = "young",
       .place = [](Draft& d) { return &Contact{}(d)->young; },
       .unit = "Pa",
       .range = positive,
       .help = "Young's modulus; the default is steel"},
      {.name = "poisson",
       .place = [](Draft& d) { return &Contact{}(d)->poisson; },
       .range = {.low = -1, .high = 0.5, .low_itself = false},
       .help = "Poisson's ratio"},
  };
}

Table hertz_contact() {
  return {.path = "effects.hertz_contact",
          .help = "Elastic spheres push each other apart, F = 4/3 E* sqrt(R_eff) overlap^(3/2) (D 5.9).",
          .open = [](Draft& d, int) { d.scene.effects.hertz_contact.emplace(); },
          .keys = elastic_constants([](Draft& d) { return &*d.scene.effects.hertz_contact; })};
}

Table wall_contact() {
  return {.path = "effects.wall_contact",
          .help = "The same against the sides of the domain and the electrodes.",
          .open = [](Draft& d, int) { d.scene.effects.wall_contact.emplace(); },
          .keys = elastic_constants([](Draft& d) { return &*d.scene.effects.wall_contact; })};
}

Table contact_discharge() {
  return {.path = "effects.contact_discharge",
          .help =
              "Conductors close to each other, or to an electrode, become one electrically (D 6.40). "
              "Needs floating_conductors.",
          .open = [](Draft& d, int) { d.scene.effects.contact_discharge.emplace(); },
          .keys = {
              {.name = "gap",
               .place = [](Draft& d) { return &d.contact_gap; },
               .unit = "m",
               .range = positive,
               .computed_default = "the smallest radius",
               .help = "contact is made when two surfaces come closer than this"},
              {.name = "hysteresis",
               .place = [](Draft& d) { return &d.scene.effects.contact_discharge->hysteresis; },
               .range = {.low = 0, .high = 1},
               .help = "contact is lost beyond gap * (1 + hysteresis): conductors at rest there must not chatter"},
          }};
}

Table contact_potential() {
  return {
      .path = "effects.contact_potential",
      .help =
          "Particles rest where stiffness * sum of (q - 1) ln q over all pairs and walls that overlap is least; q is "
          "the distance of the centres over the sum of the radii, or of a centre from a wall over its radius. A run "
          "looks for that in place of a motion in time, so no other effect is allowed.",
      .open = [](Draft& d, int) { d.scene.effects.contact_potential.emplace(); },
      .keys = {
          {.name = "stiffness",
           .place = [](Draft& d) { return &d.scene.effects.contact_potential->stiffness; },
           .unit = "J",
           .range = positive,
           .help = "k: changes energies and forces, not where particles rest"},
          {.name = "box",
           .place = [](Draft& d) { return &d.scene.effects.contact_potential->box; },
           .help = "the sides of the domain are walls; without them every [[wall]] must be given"},
      }};
}

Table minimize() {
  return {
      .path = "minimize",
      .help = "How particles under effects.contact_potential come to rest.",
      .keys = {
          {.name = "method",
           .place = [](Draft& d) { return &d.scene.minimize.method; },
           .choices = {"lbfgs-newton", "lbfgs", "newton-cg", "fire", "gradient-descent"},
           .help =
               "lbfgs-newton: limited-memory BFGS until the contacts have settled, then Newton's method with "
               "conjugate gradients; fire: inertial relaxation; gradient-descent: small steps of one length down the "
               "gradient, which end in the minimum that the gradient flow leads to. Others end in other minima"},
          {.name = "force_tolerance",
           .place = [](Draft& d) { return &d.scene.minimize.force_tolerance; },
           .range = accuracy,
           .help = "at rest: the largest net force on a particle, in units of stiffness over the mean diameter"},
          {.name = "max_iterations",
           .place = [](Draft& d) { return &d.scene.minimize.max_iterations; },
           .range = {.low = 0, .high = 1e12},
           .help = "a run ends there at the latest"},
          {.name = "step",
           .place = [](Draft& d) { return &d.scene.minimize.step; },
           .range = positive,
           .help = "of gradient-descent, in units of the mean diameter squared over stiffness"},
          {.name = "record_every",
           .place = [](Draft& d) { return &d.scene.minimize.record_every; },
           .range = not_negative,
           .help = "iterations between two frames; 0: at 0, 1, 2, 3, 4, 6, 8, 11, 16, ..., and the last"},
          {.name = "threads",
           .place = [](Draft& d) { return &d.scene.minimize.threads; },
           .range = {.low = 0, .high = 1024},
           .help = "that share the work, for the same bits; 0: one a core, fewer for few particles"},
      }};
}

Table leakage() {
  return {.path = "effects.leakage",
          .help =
              "Ohmic conduction through the fluid: charge decays with the time permittivity / conductivity. Needs "
              "floating_conductors.",
          .open = [](Draft& d, int) { d.scene.effects.leakage.emplace(); },
          .keys = {
              {.name = "conductivity",
               .place = [](Draft& d) { return &d.scene.effects.leakage->conductivity; },
               .unit = "S/m",
               .range = positive,
               .required = true,
               .help = "of the fluid"},
          }};
}

Table contact_resistance() {
  return {.path = "effects.contact_resistance",
          .help =
              "A contact conducts instead of making two one: resistance + resistivity / (2 spot), after Holm. Needs "
              "contact_discharge, which says who is in contact.",
          .open = [](Draft& d, int) { d.scene.effects.contact_resistance.emplace(); },
          .keys = {
              {.name = "resistance",
               .place = [](Draft& d) { return &d.scene.effects.contact_resistance->resistance; },
               .unit = "ohm",
               .range = not_negative,
               .help = "of one contact"},
              {.name = "resistivity",
               .place = [](Draft& d) { return &d.scene.effects.contact_resistance->resistivity; },
               .unit = "ohm m",
               .range = not_negative,
               .help = "of the conductors; needs spot"},
              {.name = "spot",
               .place = [](Draft& d) { return &d.scene.effects.contact_resistance->spot; },
               .unit = "m",
               .range = not_negative,
               .help = "radius of the spot in which two surfaces touch"},
          }};
}

Table field() {
  return {
      .path = "field",
      .help = "How the potential is computed.",
      .keys = {
          {.name = "accuracy",
           .place = [](Draft& d) { return &d.scene.field.accuracy; },
           .range = {.low = 1e-12, .high = 0.1},
           .computed_default = "none; cells and tolerances count",
           .help =
               "chooses cells, tolerances and, unless given, the method, so that no error is larger: of a potential "
               "over the largest difference of potentials, of a conductor's charge over the largest, of a force on a "
               "disk over the largest. A run is chosen for at its start, for gaps down to contact_discharge's, and "
               "checked at checkpoints"},
          {.name = "method",
           .place = [](Draft& d) { return &d.scene.field.method; },
           .choices = {"cut-cell", "multipole", "relaxation"},
           .help =
               "cut-cell: finite volumes, one linear system; multipole: spectral, as many digits as asked for, disks "
               "only; relaxation: lattice and gradient descent (D 6.3-6.5)"},
          {.name = "cells",
           .place = [](Draft& d) { return &d.scene.field.cells; },
           .range = {.low = 8, .high = most_cells},
           .help =
               "square cells along the domain's longer side; of multipole, which needs none, those of its pictures"},
          {.name = "tolerance",
           .place = [](Draft& d) { return &d.tolerance; },
           .range = accuracy,
           .computed_default = "1e-8; 1e-10 of multipole, 1e-4 of relaxation",
           .help =
               "error of a single solve: of cut-cell in the energy norm, relative to the solution's; of multipole in "
               "potentials, charges and forces, relative to the largest; of relaxation in the groups' charges"},
          {.name = "moving_tolerance",
           .place = [](Draft& d) { return &d.moving_tolerance; },
           .range = accuracy,
           .computed_default = "1e-5; 1e-6 of multipole, 1e-4 of relaxation",
           .help = "the same for the solves of a moving scene"},
          {.name = "device",
           .place = [](Draft& d) { return &d.scene.field.device; },
           .choices = {"cpu", "cuda"},
           .help = "where cut-cell solves; --device on the command line comes first"},
          {.name = "threads",
           .place = [](Draft& d) { return &d.scene.field.threads; },
           .range = {.low = 0, .high = 1024},
           .help = "that cut-cell shares its work among, for the same bits; 0: one a core, fewer on small grids"},
          {.name = "links",
           .place = [](Draft& d) { return &d.scene.field.links; },
           .choices = {"log-fitted", "plain", "aperture"},
           .help =
               "conductance from a cell to a disk: exact for a logarithmic potential, or for a linear one; aperture: "
               "the obvious, first-order, to compare with (linear_solver = \"assembled\")"},
          {.name = "linear_solver",
           .place = [](Draft& d) { return &d.scene.field.linear_solver; },
           .choices = {"multigrid", "assembled"},
           .help = "multigrid: matrix-free, the fastest; assembled: any preconditioner of PETSc"},
          {.name = "relaxation_eta",
           .place = [](Draft& d) { return &d.relaxation_eta; },
           .unit = "V m/C",
           .range = positive,
           .computed_default = "chosen by the solver",
           .help = "step of the gradient descent (D 6.30)"},
      }};
}

Table mechanics() {
  return {.path = "mechanics",
          .help = "How the motion is computed.",
          .keys = {
              {.name = "integrator",
               .place = [](Draft& d) { return &d.scene.mechanics.integrator; },
               .choices = {"cvode", "euler"},
               .help = "cvode: implicit, error-controlled, contacts located as events; euler: explicit (D 6.7)"},
              {.name = "coupling",
               .place = [](Draft& d) { return &d.scene.mechanics.coupling; },
               .choices = {"split", "monolithic"},
               .help = "split: field extrapolated over error-controlled steps; monolithic: solved in each evaluation"},
              {.name = "predictor",
               .place = [](Draft& d) { return &d.scene.mechanics.predictor; },
               .help = "split: between field solves, solves on a coarser grid that resolves the conductors"},
              {.name = "relative_tolerance",
               .place = [](Draft& d) { return &d.scene.mechanics.relative_tolerance; },
               .range = accuracy,
               .help = "of positions and momenta, each step of the integrator"},
              {.name = "position_tolerance",
               .place = [](Draft& d) { return &d.position_tolerance; },
               .unit = "m",
               .range = positive,
               .computed_default = "1e-3 * the smallest radius",
               .help = "error of the positions allowed in a coupling step"},
              {.name = "largest_step",
               .place = [](Draft& d) { return &d.largest_step; },
               .unit = "s",
               .range = positive,
               .computed_default = "output.every",
               .help = "largest coupling step"},
              {.name = "euler_step",
               .place = [](Draft& d) { return &d.scene.mechanics.euler_step; },
               .unit = "s",
               .range = positive,
               .help = "time step of euler"},
              {.name = "euler_field_step",
               .place = [](Draft& d) { return &d.scene.mechanics.euler_field_step; },
               .unit = "s",
               .range = positive,
               .help = "time between two field solves of euler"},
          }};
}

Table network_table() {
  Table table = {
      .path = "network",
      .help = "Resistors between particles that touch: what `lichtenberg network` measures in a packing's result file.",
      .keys = {
          {.name = "model",
           .place = [](Draft& d) { return &d.scene.network.model; },
           .choices = {"particle", "contact"},
           .computed_default = "both, one after the other",
           .help = "what a node of the network is, and with it between what the resistors are"},
          {.name = "between",
           .place = [](Draft& d) { return &d.scene.network.between; },
           .help = "electrodes, the first at 0 V: names of walls or numbers of particles"},
          {.name = "resistor",
           .place = [](Draft& d) { return &d.scene.network.resistor; },
           .computed_default = "\"constant\", of 1 Ohm",
           .help = "model of a resistor, with the parameters that it needs:"},
      }};
  Key& resistor = table.keys.back();
  for (const network::ResistorModel& model : network::resistor_models()) {
    resistor.choices.push_back(model.name);
    resistor.help += fmt::format(" {} ({}), {};", model.name, fmt::join(model.needs, ", "), model.help);
  }
  resistor.help.back() = '.';
  const auto add = [&](const char* name, Place place) {
    const auto& entry = *std::ranges::find(network::parameter_entries(), std::string_view(name),
                                           &network::ParameterEntry::name);
    table.keys.push_back({.name = name,
                          .place = place,
                          .unit = entry.unit,
                          .range = positive,
                          .computed_default = "none",
                          .help = entry.help});
  };
  add("resistance", [](Draft& d) { return &d.scene.network.parameters.resistance; });
  add("resistance_per_length", [](Draft& d) { return &d.scene.network.parameters.resistance_per_length; });
  add("sheet_resistance", [](Draft& d) { return &d.scene.network.parameters.sheet_resistance; });
  add("resistivity", [](Draft& d) { return &d.scene.network.parameters.resistivity; });
  add("spot", [](Draft& d) { return &d.scene.network.parameters.spot; });
  return table;
}

Table output() {
  return {.path = "output",
          .help = "What a run leaves.",
          .keys = {
              {.name = "file",
               .place = [](Draft& d) { return &d.output_file; },
               .computed_default = "the scene file's name, in the working directory, with .h5",
               .help = "result file"},
              {.name = "every",
               .place = [](Draft& d) { return &d.scene.output.every; },
               .unit = "s",
               .range = positive,
               .help = "simulated time between two frames"},
              {.name = "checkpoint_every",
               .place = [](Draft& d) { return &d.scene.output.checkpoint_every; },
               .range = {.low = 1, .high = 1e9},
               .help = "frames between two checkpoints"},
              {.name = "picture",
               .place = [](Draft& d) { return &d.scene.output.picture; },
               .help = "draw the final state"},
          }};
}

Table stop() {
  return {.path = "stop",
          .help = "When a run ends: at whichever comes first.",
          .keys = {
              {.name = "time",
               .place = [](Draft& d) { return &d.scene.stop.time; },
               .unit = "s",
               .range = positive,
               .help = "simulated time"},
              {.name = "stationary",
               .place = [](Draft& d) { return &d.scene.stop.stationary; },
               .help = "stop when all conductors are connected to an electrode and the forces are negligible (D 7.1)"},
              {.name = "force",
               .place = [](Draft& d) { return &d.scene.stop.force; },
               .range = accuracy,
               .help = "negligible: this fraction of the largest force of the run"},
          }};
}

}  // namespace

const std::vector<Table>& schema() {
  static const std::vector<Table> tables = {top(),
                                            domain(),
                                            medium(),
                                            material(),
                                            electrode(),
                                            wall(),
                                            conductor(),
                                            group(),
                                            population(),
                                            effects(),
                                            floating_conductors(),
                                            current_source(),
                                            stokes_drag(),
                                            hertz_contact(),
                                            wall_contact(),
                                            contact_discharge(),
                                            leakage(),
                                            contact_resistance(),
                                            contact_potential(),
                                            minimize(),
                                            field(),
                                            mechanics(),
                                            network_table(),
                                            output(),
                                            stop()};
  return tables;
}

const Table* find_table(std::string_view path) {
  const auto found = std::ranges::find(schema(), path, &Table::path);
  return found == schema().end() ? nullptr : &*found;
}

const Key* find_key(const Table& table, std::string_view name) {
  const auto found = std::ranges::find(table.keys, name, &Key::name);
  return found == table.keys.end() ? nullptr : &*found;
}

std::string path_in(const Table& table, std::string_view name) {
  return table.path.empty() ? std::string(name) : fmt::format("{}.{}", table.path, name);
}

std::vector<std::string> known_paths() {
  std::vector<std::string> known;
  for (const Table& table : schema()) {
    if (!table.path.empty()) known.push_back(table.path);
    for (const Key& key : table.keys) known.push_back(path_in(table, key.name));
  }
  return known;
}

Draft blank_draft() {
  Draft draft;
  for (const Table& table : schema()) table.open(draft, 0);
  return draft;
}

bool Range::contains(double value) const {
  return std::isfinite(value) && (low_itself ? value >= low : value > low) &&
         (high_itself ? value <= high : value < high);
}

std::string Range::text() const {
  std::vector<std::string> ends;
  if (std::isfinite(low)) ends.push_back(fmt::format("{} {:.10g}", low_itself ? "at least" : "greater than", low));
  if (std::isfinite(high)) ends.push_back(fmt::format("{} {:.10g}", high_itself ? "at most" : "less than", high));
  return fmt::format("{}", fmt::join(ends, " and "));
}

std::string Key::allowed() const {
  if (!choices.empty()) return fmt::format("one of \"{}\"", fmt::join(choices, "\", \""));
  std::string text = std::visit([]<class T>(At<T>) { return type_name(T{}); }, place);
  if (!unit.empty()) text += " in " + unit;
  const std::string limits = range.text();
  return limits.empty() ? text : text + ", " + limits;
}

std::string Key::fallback() const {
  if (required) return "required";
  if (!shapes.empty()) return fmt::format("required for {}", fmt::join(shapes, ", "));
  if (!computed_default.empty()) return "default: " + computed_default;
  Draft untouched = blank_draft();
  return "default: " + std::visit([&](auto at) { return show(*at(untouched)); }, place);
}

std::string Table::header() const {
  if (path.empty()) return "(top of the file)";
  return kind == repeated ? "[[" + path + "]]" : "[" + path + "]";
}

}  // namespace lichtenberg
