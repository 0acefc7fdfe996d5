// Tables of the effects.
#include "src/scene/schema_tables.hpp"

namespace lichtenberg::tables {

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

namespace {

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

}  // namespace

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

}  // namespace lichtenberg::tables
