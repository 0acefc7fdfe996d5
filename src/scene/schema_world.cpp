// Tables of the domain, its fluid, electrodes and circuits, and walls.
#include "solvers/geometry/box.hpp"
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace tables {
namespace {

using namespace ranges;

using enum Table::Kind;

Table top() {
  return {.help = "Title of the run and seed of its random numbers.",
          .keys = {
              {.name = "title",
               .target = [](Draft& d) { return &d.scene.title; },
               .computed_default = "none",
               .help = "title of the run in pictures and summaries"},
              {.name = "seed",
               .target = [](Draft& d) { return &d.seed; },
               .range = not_negative,
               .help = "seed of all random numbers: initial positions, radii, velocities and charges of populations, "
                       "charge_exchange and gas_drag"},
          }};
}

/// Returns the key of the side with index `s` in side_names.
template <int s>
Key side(const std::string& help) {
  return {
      .name = std::string(side_names[s]), .target = [](Draft& d) { return &d.scene.domain.sides[s]; }, .help = help};
}

Table domain() {
  const std::string help =
      "side of the domain: insulating (no field through it), an electrode at a potential, or periodic: bodies that "
      "leave through it enter through the opposite side";
  const std::string in_space = help + "; in three dimensions";
  return {
      .path = "domain",
      .kind = required,
      .help = "The rectangle [0, size x] x [0, size y] filled with fluid; with a third number of size a cuboid.",
      .keys = {
          {.name = "size",
           .target = [](Draft& d) { return &d.domain_size; },
           .unit = "m",
           .range = {.low = smallest_size, .high = largest_size},
           .required = true,
           .help = "lengths of the domain's sides in m, along x (left to right), y (bottom to top) and, in three "
                   "dimensions, z (front to back)"},
          side<0>(help),
          side<1>(help),
          side<2>(help),
          side<3>(help),
          side<4>(in_space),
          side<5>(in_space),
          {.name = "unbounded",
           .target = [](Draft& d) { return &d.scene.domain.open; },
           .help = "true: the domain has no sides and is free space in three dimensions, with a potential of 0 at "
                   "infinity and any net charge; domain.size is then the size of the region of initial positions. "
                   "Needs floating_conductors or [units]; grains may also move in a plane",
           .old_name = "open"},
          {.name = "uniform_field",
           .target = [](Draft& d) { return &d.uniform_field; },
           .unit = "V/m",
           .range = {.low = -largest_size, .high = largest_size},
           .computed_default = "[0, 0, 0]",
           .help = "external uniform field E = [x, y, z] in V/m, far from all conductors; its potential -E.r is 0 at "
                   "the origin. Needs unbounded = true"},
      }};
}

Table medium() {
  return {.path = "medium",
          .help = "Properties of the fluid between the conductors.",
          .keys = {
              {.name = "relative_permittivity",
               .target = [](Draft& d) { return &d.relative_permittivity; },
               .range = {.low = 1},
               .computed_default = "none; floating_conductors needs it or permittivity",
               .help = "relative permittivity of the fluid, in units of the vacuum's, 8.8541878128e-12 F/m"},
              {.name = "permittivity",
               .target = [](Draft& d) { return &d.permittivity; },
               .unit = "F/m",
               .range = positive,
               .computed_default = "from relative_permittivity",
               .help = "absolute permittivity of the fluid, in F/m; give this or relative_permittivity, not both"},
              {.name = "viscosity",
               .target = [](Draft& d) { return &d.viscosity; },
               .unit = "Pa s",
               .range = positive,
               .computed_default = "none; stokes_drag needs it",
               .help = "dynamic viscosity of the fluid, in Pa s"},
              {.name = "depth",
               .target = [](Draft& d) { return &d.depth; },
               .unit = "m",
               .range = positive,
               .computed_default = "2 * the largest radius: a monolayer; 1 m without conductors",
               .help = "thickness of the system along z in a plane model, in m: charges, forces and energies per metre "
                       "of the two-dimensional field are multiplied by it"},
              {.name = "temperature",
               .target = [](Draft& d) { return &d.scene.medium.temperature; },
               .unit = "K",
               .range = positive,
               .help = "temperature of the fluid, in K: the entropy production is the dissipated power over it; it has "
                       "no other effect"},
          }};
}

Table material() {
  return {
      .path = "material",
      .help = "Material of the conductors.",
      .keys = {
          {.name = "density",
           .target = [](Draft& d) { return &d.scene.material.density; },
           .unit = "kg/m^3",
           .range = positive,
           .help =
               "mass density of the conductors, in kg/m^3, whose masses are those of spheres; the default is steel, "
               "for grains mass 1 at diameter 1"},
      }};
}

std::vector<Key> electrode_source_keys() {
  return {
      {.name = "name",
       .target = [](Draft& d) { return &d.electrodes.back().name; },
       .computed_default = "the shape and a number, as in \"disk 1\"",
       .help = "name of the electrode in messages and results"},
      {.name = "shape",
       .target = [](Draft& d) { return &d.electrodes.back().shape; },
       .texts = {"disk", "half-disk", "bar", "ring", "polygon", "ellipse", "curve", "sphere", "torus"},
       .required = true,
       .help = "shape of the electrode. disk: a whole disk; half-disk: a disk centred on a side of the domain; bar: a "
               "straight bar with flat ends; ring: conducting outside its circle; polygon: through points in order; "
               "curve: a smooth closed curve through points. In three dimensions sphere, or torus: a wire loop around "
               "the z axis, as a closed chain of spheres whose electrodes are named \"NAME 1\", \"NAME 2\", ..."},
      {.name = "potential",
       .target = [](Draft& d) { return &d.electrodes.back().potential; },
       .unit = "V",
       .computed_default = "none; needed without charge and without a [[circuit]] that lists the electrode",
       .help =
           "potential of the electrode, in V, or of its voltage source if there is a series resistance; constant or "
           "a function of time (s)"},
      {.name = "charge",
       .target = [](Draft& d) { return &d.electrodes.back().charge; },
       .unit = "C",
       .computed_default = "none",
       .help = "charge of a floating electrode, in C, instead of a potential"},
      {.name = "series_resistance",
       .target = [](Draft& d) { return &d.electrodes.back().series_resistance; },
       .unit = "ohm",
       .range = positive,
       .computed_default = "none",
       .help = "resistance between the voltage source and the electrode, in ohm. The electrode starts without charge, "
               "and its potential follows from the current"},
  };
}

std::vector<Key> electrode_shape() {
  return {
      {.name = "centre",
       .target = [](Draft& d) { return &d.electrodes.back().centre; },
       .unit = "m",
       .shapes = {"disk", "ring", "ellipse"},
       .help = "centre of the disk, of the ring's circle or of the ellipse, in m"},
      {.name = "position",
       .target = [](Draft& d) { return &d.electrodes.back().position; },
       .unit = "m",
       .shapes = {"sphere", "torus"},
       .help = "position of the centre of the sphere or torus, in m"},
      {.name = "radius",
       .target = [](Draft& d) { return &d.electrodes.back().radius; },
       .unit = "m",
       .range = positive,
       .shapes = {"disk", "half-disk", "ring", "sphere", "torus"},
       .help = "radius of the disk, the half-disk, the ring's circle, the sphere or the circle in the middle of the "
               "torus's wire, in m"},
      {.name = "wire_radius",
       .target = [](Draft& d) { return &d.electrodes.back().wire_radius; },
       .unit = "m",
       .range = positive,
       .shapes = {"torus"},
       .help = "radius of the torus's wire, in m, at most an eighth of its radius. The spheres of the chain have 1.134 "
               "times this radius, so that the capacitance is that of the torus within 0.2 %"},
      {.name = "side",
       .target = [](Draft& d) { return &d.electrodes.back().side; },
       .texts = {"left", "right", "bottom", "top"},
       .shapes = {"half-disk"},
       .help = "side of the domain on which the centre of the half-disk lies"},
      {.name = "at",
       .target = [](Draft& d) { return &d.electrodes.back().at; },
       .unit = "m",
       .range = not_negative,
       .shapes = {"half-disk"},
       .help =
           "position of the half-disk's centre along its side, in m: x on the bottom or top, y on the left or right"},
      {.name = "from",
       .target = [](Draft& d) { return &d.electrodes.back().from; },
       .unit = "m",
       .shapes = {"bar"},
       .help = "start point of the bar's axis, in m; the bar is cut flat there"},
      {.name = "to",
       .target = [](Draft& d) { return &d.electrodes.back().to; },
       .unit = "m",
       .shapes = {"bar"},
       .help = "end point of the bar's axis, in m; the bar is cut flat there"},
      {.name = "width",
       .target = [](Draft& d) { return &d.electrodes.back().width; },
       .unit = "m",
       .range = positive,
       .shapes = {"bar"},
       .help = "width of the bar across its axis, in m"},
  };
}

/// Returns the keys of electrodes that are closed curves.
std::vector<Key> electrode_curve() {
  return {
      {.name = "points",
       .target = [](Draft& d) { return &d.electrodes.back().points; },
       .unit = "m",
       .shapes = {"polygon", "curve"},
       .help =
           "corners of the polygon, or points of the curve, in order, in m. The last is joined to the first. A curve "
           "is a cubic spline over the lengths between its points"},
      {.name = "corner_radius",
       .target = [](Draft& d) { return &d.electrodes.back().corner_radius; },
       .unit = "m",
       .range = not_negative,
       .optional_shapes = {"polygon"},
       .help = "radius of the circles that round the corners of the polygon, in m; 0: sharp corners"},
      {.name = "semi_axes",
       .target = [](Draft& d) { return &d.electrodes.back().semi_axes; },
       .unit = "m",
       .range = positive,
       .shapes = {"ellipse"},
       .help = "two semi-axes of the ellipse, in m"},
      {.name = "angle",
       .target = [](Draft& d) { return &d.electrodes.back().angle; },
       .unit = "degrees",
       .range = {.low = -360, .high = 360},
       .optional_shapes = {"ellipse"},
       .help = "angle from x to the first semi-axis of the ellipse, in degrees, anticlockwise"},
      {.name = "hollow",
       .target = [](Draft& d) { return &d.electrodes.back().hollow; },
       .optional_shapes = {"polygon", "ellipse", "curve"},
       .help = "true: the electrode conducts outside its curve instead, as a ring does"},
  };
}

Table electrode() {
  return {
      .path = "electrode",
      .kind = repeated,
      .help =
          "An electrode: a fixed conducting body at a given potential, or connected to a voltage source by a series "
          "resistance. In two dimensions it may reach beyond the domain, which cuts it.",
      .open = [](Draft& d, int line) { d.electrodes.push_back({.line = line}); },
      .keys = joined({electrode_source_keys(), electrode_shape(), electrode_curve()})};
}

std::vector<Key> circuit_keys() {
  return {
      {.name = "name",
       .target = [](Draft& d) { return &d.circuits.back().name; },
       .computed_default = "\"circuit\" and a number, as in \"circuit 1\"",
       .help = "name of the circuit in messages and results"},
      {.name = "electrodes",
       .target = [](Draft& d) { return &d.circuits.back().electrodes; },
       .required = true,
       .help = "names of the electrodes, sides of the domain and groups that the circuit joins to one potential; they "
               "have no potential of their own. A side in this list is an electrode"},
      {.name = "potential",
       .target = [](Draft& d) { return &d.circuits.back().potential; },
       .unit = "V",
       .computed_default = "none",
       .help = "potential of the voltage source, in V, constant or a function of time (s)"},
      {.name = "resistance",
       .target = [](Draft& d) { return &d.circuits.back().resistance; },
       .unit = "ohm",
       .range = positive,
       .computed_default = "none: the voltage source is connected directly",
       .help = "resistance between the voltage source and the electrodes, in ohm"},
      {.name = "current",
       .target = [](Draft& d) { return &d.circuits.back().current; },
       .unit = "A",
       .computed_default = "none",
       .help = "current of a current source into the electrodes, in A, constant or a function of time (s), instead of "
               "or in addition to a voltage source behind a resistance"},
      {.name = "capacitance",
       .target = [](Draft& d) { return &d.circuits.back().capacitance; },
       .unit = "F",
       .range = positive,
       .computed_default = "none",
       .help = "capacitance of a capacitor between the electrodes and 0 V, in F"},
      {.name = "charge",
       .target = [](Draft& d) { return &d.circuits.back().charge; },
       .unit = "C",
       .computed_default = "0",
       .help = "charge of the electrodes and the capacitor together at the start, in C"},
  };
}

Table circuit() {
  return {.path = "circuit",
          .kind = repeated,
          .help =
              "A circuit: electrodes, sides and groups with one potential, connected to a voltage source, directly or "
              "through a resistance, or by a current source. Without a source their potential floats.",
          .open = [](Draft& d, int line) { d.circuits.push_back({.line = line}); },
          .keys = circuit_keys()};
}

Table wall() {
  return {
      .path = "wall",
      .kind = repeated,
      .help = "An infinite flat wall in addition to the sides of the domain. Needs effects.soft_repulsion.",
      .open = [](Draft& d, int line) { d.walls.push_back({.line = line}); },
      .keys = {
          {.name = "name",
           .target = [](Draft& d) { return &d.walls.back().name; },
           .computed_default = "\"wall\" and a number, as in \"wall 1\"",
           .help = "name of the wall in messages and results"},
          {.name = "point",
           .target = [](Draft& d) { return &d.walls.back().point; },
           .unit = "m",
           .required = true,
           .help = "coordinates of any point on the wall, in m"},
          {.name = "normal",
           .target = [](Draft& d) { return &d.walls.back().normal; },
           .required = true,
           .help = "normal vector of the wall, which points to the side of the particles; its length may be any but 0"},
      }};
}

}  // namespace
}  // namespace tables

std::vector<Table> tables_of_the_world() {
  using namespace tables;
  return {top(), domain(), medium(), material(), electrode(), circuit(), wall()};
}

}  // namespace lichtenberg
