// Tables of the conductors and grains: single ones, groups and populations.
#include "src/scene/schema.hpp"

namespace lichtenberg {
namespace tables {
namespace {

using namespace ranges;

using enum Table::Kind;

/// Returns the material keys of `particles`, the draft's conductors or populations.
template <auto particles>
std::vector<Key> material_keys(KeyTarget relative_resistivity) {
  return {
      {.name = "relative_resistivity",
       .target = relative_resistivity,
       .range = positive,
       .help = "factor of the particle's resistivity or resistance in the resistor network, relative to the parameters "
               "in [network]"},
      {.name = "young",
       .target = [](Draft& d) { return &(d.*particles).back().young; },
       .unit = "Pa",
       .range = positive,
       .computed_default = "effects.hertz_contact.young, or without that effect effects.wall_contact.young",
       .help = "Young's modulus of the conductor's material in elastic contacts, in Pa"},
      {.name = "poisson",
       .target = [](Draft& d) { return &(d.*particles).back().poisson; },
       .range = {.low = -1, .high = 0.5, .low_itself = false},
       .computed_default = "effects.hertz_contact.poisson, or effects.wall_contact.poisson",
       .help = "Poisson's ratio of the conductor's material in elastic contacts"},
  };
}

GrainMaterial& material_of_conductor(Draft& d) { return d.conductors.back().conductor.material; }
GrainMaterial& material_of_population(Draft& d) { return d.populations.back().material; }

/// Returns the keys of a grain's material. `material`: material in the draft of a conductor or population.
/// `permittivity`: target of its relative permittivity.
template <GrainMaterial& (*material)(Draft&)>
std::vector<Key> grain_material_keys(KeyTarget permittivity) {
  constexpr Range factor = {.low = 1e-6, .high = 1e6};
  return {
      {.name = "relative_permittivity",
       .target = permittivity,
       .range = {.low = 1, .high = 1e6, .low_itself = false},
       .computed_default = "from effects.induced_dipoles.polarizability",
       .help = "relative permittivity eps_r of a dielectric grain, whose polarizability then is (eps_r - 1) / (eps_r + "
               "2) R^3 with its radius R; needs [effects.induced_dipoles]"},
      {.name = "relative_density",
       .target = [](Draft& d) { return &material(d).density; },
       .range = factor,
       .help = "density of a grain relative to material.density"},
      {.name = "relative_stiffness",
       .target = [](Draft& d) { return &material(d).stiffness; },
       .range = factor,
       .help =
           "stiffness of the contact of two such grains relative to that of the contact law; the elastic constants of "
           "two materials add like springs in series"},
      {.name = "relative_damping",
       .target = [](Draft& d) { return &material(d).damping; },
       .range = factor,
       .help = "ratio of damping to stiffness of the contact of two such grains, relative to that of the contact law"},
  };
}

std::vector<Key> conductor_sphere() {
  return {
      {.name = "position",
       .target = [](Draft& d) { return &d.conductors.back().position; },
       .unit = "m",
       .required = true,
       .help = "position of the conductor's centre, in m"},
      {.name = "radius",
       .target = [](Draft& d) { return &d.conductors.back().conductor.radius; },
       .unit = "m",
       .range = positive,
       .required = true,
       .help = "radius of the conductor, in m"},
  };
}

std::vector<Key> conductor_state() {
  return {
      {.name = "charge",
       .target = [](Draft& d) { return &d.conductors.back().charge; },
       .unit = "C",
       .computed_default = "0",
       .help = "charge of the conductor at the start, in C; not allowed for a member of a group. For grains without "
               "[units] also a number of elementary charges, as in \"1000 e\""},
      {.name = "velocity",
       .target = [](Draft& d) { return &d.conductors.back().velocity; },
       .unit = "m/s",
       .computed_default = "0 along each axis",
       .help = "velocity of the conductor at the start, in m/s"},
      {.name = "angular_velocity",
       .target = [](Draft& d) { return &d.conductors.back().angular_velocity; },
       .unit = "1/t0",
       .computed_default = "0 about each axis",
       .help = "angular velocity of a grain at the start, in reduced units (1/t0): three numbers, in two dimensions "
               "[0, 0, w]; needs [effects.friction]"},
      {.name = "fixed",
       .target = [](Draft& d) { return &d.conductors.back().conductor.fixed; },
       .help = "true: the conductor does not move",
       .old_name = "held"},
      {.name = "group",
       .target = [](Draft& d) { return &d.conductors.back().group; },
       .computed_default = "none",
       .help = "name of the [[group]] that the conductor belongs to"},
  };
}

Table conductor() {
  return {.path = "conductor",
          .kind = repeated,
          .help =
              "A conductor that moves unless it is fixed: a disk for a field in the plane, a sphere for a field in "
              "space and for the mechanics.",
          .open = [](Draft& d, int line) { d.conductors.push_back({.line = line}); },
          .keys = joined({conductor_sphere(), material_keys<&Draft::conductors>([](Draft& d) {
                            return &d.conductors.back().conductor.relative_resistivity;
                          }),
                          grain_material_keys<material_of_conductor>(
                              [](Draft& d) { return &d.conductors.back().conductor.permittivity; }),
                          conductor_state()})};
}

Table group() {
  return {.path = "group",
          .kind = repeated,
          .help =
              "A group of electrically connected conductors: they have one potential, whether they touch or not. Give "
              "its charge or its potential.",
          .open = [](Draft& d, int line) { d.groups.push_back({.line = line}); },
          .keys = {
              {.name = "name",
               .target = [](Draft& d) { return &d.groups.back().name; },
               .required = true,
               .help = "name of the group, by which its conductors refer to it"},
              {.name = "charge",
               .target = [](Draft& d) { return &d.groups.back().charge; },
               .unit = "C",
               .computed_default = "none",
               .help = "total charge of the group's conductors, in C; their common potential floats"},
              {.name = "potential",
               .target = [](Draft& d) { return &d.groups.back().potential; },
               .unit = "V",
               .computed_default = "none",
               .help = "given potential of the group's conductors, in V, constant or a function of time (s); their "
                       "charge follows from the field"},
          }};
}

std::vector<Key> population_radii() {
  return {
      {.name = "count",
       .target = [](Draft& d) { return &d.populations.back().count; },
       .range = {.low = 1, .high = 1e7},
       .required = true,
       .help = "number of bodies in the population: at most 1e6 conductors or 1e7 grains"},
      {.name = "radius",
       .target = [](Draft& d) { return &d.populations.back().radius; },
       .unit = "m",
       .range = positive,
       .computed_default = "none; needed unless radii are given; 0.5 of grains",
       .help = "radius of all bodies of the population, in m, or an interval [smallest, largest] for random radii"},
      {.name = "radii",
       .target = [](Draft& d) { return &d.populations.back().radii; },
       .unit = "m",
       .range = positive,
       .computed_default = "none",
       .help =
           "list of radii in m, one for each body, instead of radius; it repeats if count is larger than its length"},
      {.name = "distribution",
       .target = [](Draft& d) { return &d.populations.back().distribution; },
       .help = "distribution of random radii, truncated to their interval. uniform: constant probability density; "
               "normal: Gaussian, given by mean and deviation; lognormal: Gaussian in the logarithm of the radius"},
      {.name = "mean",
       .target = [](Draft& d) { return &d.populations.back().mean; },
       .unit = "m",
       .range = positive,
       .computed_default = "the middle of the interval",
       .help = "mean radius in m of the distribution normal, before the truncation; median radius of lognormal"},
      {.name = "deviation",
       .target = [](Draft& d) { return &d.populations.back().deviation; },
       .range = positive,
       .computed_default = "none; needed for normal and lognormal",
       .help = "standard deviation of random radii, dimensionless. normal: standard deviation over mean radius; "
               "lognormal: standard deviation of the logarithm of the radius"},
      {.name = "overlapping",
       .target = [](Draft& d) { return &d.populations.back().overlapping; },
       .help = "true: initial positions of the bodies may overlap; needs effects.soft_repulsion"},
  };
}

std::vector<Key> population_charges() {
  return {
      {.name = "charge",
       .target = [](Draft& d) { return &d.populations.back().charge; },
       .unit = "C",
       .help = "initial charge of each body of the population, in C; with charge_distribution the width of the random "
               "charges. For grains without [units] also a number of elementary charges, as in \"1000 e\""},
      {.name = "charge_distribution",
       .target = [](Draft& d) { return &d.populations.back().charge_distribution; },
       .help = "distribution of the initial charges of grains. equal: all have the same charge; gaussian: normal with "
               "the standard deviation charge; exponential-power: of the density z / (2 Gamma(1/z)) exp(-|q|^z), with "
               "the charge q in units of charge and z = charge_exponent (Singh 2019, eq. 3.49). Random charges add up "
               "to exactly 0"},
      {.name = "charge_exponent",
       .target = [](Draft& d) { return &d.populations.back().charge_exponent; },
       .range = {.low = 0.25},
       .computed_default = "none; needed for exponential-power",
       .help = "exponent z of the charge distribution exp(-|q|^z): 1 is Laplace's distribution, 2 Gaussian, and from 8 "
               "on it is nearly uniform between -charge and charge. Below .25 rounding errors dominate, because the "
               "tails are too heavy"},
  };
}

std::vector<Key> population_places() {
  return {
      {.name = "temperature",
       .target = [](Draft& d) { return &d.populations.back().temperature; },
       .unit = "m0 v0^2",
       .range = not_negative,
       .computed_default = "0: at rest",
       .help = "initial temperature of grains, in reduced units (m0 v0^2): each velocity component is Gaussian, with a "
               "variance of temperature over mass, and the momenta add up to 0"},
      {.name = "velocity_spread",
       .target = [](Draft& d) { return &d.populations.back().velocity_spread; },
       .unit = "m/s",
       .range = not_negative,
       .computed_default = "from temperature",
       .help = "root mean square of each component of the initial velocities of grains, in m/s, instead of "
               "temperature: the temperature is its square times the mean mass"},
      {.name = "rotational_temperature",
       .target = [](Draft& d) { return &d.populations.back().rotational_temperature; },
       .unit = "m0 v0^2",
       .range = not_negative,
       .computed_default = "0: no rotation",
       .help = "initial rotational temperature of grains, in reduced units (m0 v0^2): each component of the angular "
               "velocity is Gaussian, with a variance of temperature over moment of inertia; needs [effects.friction]"},
      {.name = "min_gap",
       .target = [](Draft& d) { return &d.populations.back().min_gap; },
       .unit = "m",
       .range = not_negative,
       .help = "minimum initial gap to electrodes, walls, sides of the domain that are not periodic and, unless "
               "overlapping, to conductors placed before, in m"},
      {.name = "region",
       .target = [](Draft& d) { return &d.populations.back().region; },
       .unit = "m",
       .computed_default = "the whole domain",
       .help = "lower and upper corner in m of the rectangle or cuboid that contains the bodies at the start; in three "
               "dimensions a rectangle extends from front to back"},
      {.name = "round_region",
       .target = [](Draft& d) { return &d.populations.back().round_region; },
       .unit = "m",
       .computed_default = "none",
       .help = "disk [x, y, radius] in m that contains the bodies at the start, in three dimensions a cylinder from "
               "front to back, or there a sphere [x, y, z, radius]; with region the bodies are in both"},
  };
}

Table population() {
  return {.path = "population",
          .kind = repeated,
          .help =
              "A population: conductors or grains at random initial positions, drawn uniformly and sequentially, by "
              "default without overlap.",
          .open = [](Draft& d, int line) { d.populations.push_back({.line = line}); },
          .keys = joined(
              {population_radii(),
               material_keys<&Draft::populations>([](Draft& d) { return &d.populations.back().relative_resistivity; }),
               grain_material_keys<material_of_population>([](Draft& d) { return &d.populations.back().permittivity; }),
               population_charges(), population_places()})};
}

}  // namespace
}  // namespace tables

std::vector<Table> tables_of_bodies() {
  using namespace tables;
  return {conductor(), group(), population()};
}

}  // namespace lichtenberg
