#include "src/effects/effects.hpp"

#include <algorithm>
#include <array>

#include "src/effects/contact_discharge.hpp"
#include "src/effects/contact_potential.hpp"
#include "src/effects/current_source.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/stokes_drag.hpp"
#include "src/effects/wall_contact.hpp"

namespace lichtenberg::effects {
namespace {

using Solver = std::unique_ptr<laplace::LaplaceSolver>;

struct Kind {
  std::string_view name, description;
  bool (*in_scene)(const Effects&);
  std::unique_ptr<Effect> (*make)(const Scene&, Solver&);  ///< takes the solver if it is the one that needs it
};

std::unique_ptr<Effect> make_floating_conductors(const Scene& scene, Solver& solver) {
  if (!solver) {
    FieldOptions moving = scene.field;
    moving.tolerance = scene.field.moving_tolerance;
    auto effect = std::make_unique<FloatingConductors>(scene, make_field_solver(moving));
    if (const int cells = predictor_cells(scene)) {
      moving.cells = cells;
      moving.tolerance = std::max(moving.tolerance, 1e-4);  // such a grid's own error is a hundred times that
      moving.device = "cpu";
      effect->set_predictor(make_field_solver(moving));
    }
    return effect;
  }
  return std::make_unique<FloatingConductors>(scene, std::move(solver));
}

/// It is the ledger's and the circuit's (charge_ledger.hpp, circuit.hpp): nothing acts on the bodies.
std::unique_ptr<Effect> make_nothing(const Scene&, Solver&) { return nullptr; }

const std::array<Kind, 9> kinds = {{
    {"floating_conductors", "the electric field between conductors with given charges, and its forces",
     [](const Effects& e) { return e.floating_conductors.has_value(); }, make_floating_conductors},
    {"current_source", "a constant current into every conductor",
     [](const Effects& e) { return e.current_source.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> {
       return std::make_unique<CurrentSource>(s.effects.current_source->current);
     }},
    {"stokes_drag", "drag of spheres in a viscous fluid", [](const Effects& e) { return e.stokes_drag.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> {
       return std::make_unique<StokesDrag>(s.medium.viscosity);
     }},
    {"hertz_contact", "elastic contact between spheres", [](const Effects& e) { return e.hertz_contact.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> {
       return std::make_unique<HertzContact>(*s.effects.hertz_contact);
     }},
    {"wall_contact", "elastic contact of spheres with the sides of the domain and the electrodes",
     [](const Effects& e) { return e.wall_contact.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> { return std::make_unique<WallContact>(s); }},
    {"contact_discharge", "conductors that come close become one electrically",
     [](const Effects& e) { return e.contact_discharge.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> { return std::make_unique<ContactDischarge>(s); }},
    {"leakage", "the fluid conducts: charge decays with its relaxation time",
     [](const Effects& e) { return e.leakage.has_value(); }, make_nothing},
    {"contact_resistance",
     "a contact conducts instead of making two one; charge moves in implicit steps with the field",
     [](const Effects& e) { return e.contact_resistance.has_value(); }, make_nothing},
    {"contact_potential", "particles and walls that overlap push each other apart until all is at rest",
     [](const Effects& e) { return e.contact_potential.has_value(); },
     [](const Scene& s, Solver&) -> std::unique_ptr<Effect> {
       return std::make_unique<ContactPotential>(s.effects.contact_potential->stiffness, s.walls);
     }},
}};

}  // namespace

Model make_model(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver) {
  if (!solver) check_device(scene), check_can_move(scene);
  std::vector<std::unique_ptr<Effect>> effects;
  for (const Kind& kind : kinds)
    if (kind.in_scene(scene.effects))
      if (std::unique_ptr<Effect> effect = kind.make(scene, solver)) effects.push_back(std::move(effect));
  return Model(make_bodies(scene), std::move(effects), initial_charges(scene));
}

std::vector<EffectSummary> summarize_effects(const Scene& scene) {
  std::vector<EffectSummary> summaries;
  for (const Kind& kind : kinds) {
    EffectSummary summary{kind.name, kind.description, kind.in_scene(scene.effects), {}};
    Solver none;
    if (summary.in_scene)
      if (const std::unique_ptr<Effect> effect = kind.make(scene, none)) summary.needs = effect->needs();
    summaries.push_back(summary);
  }
  return summaries;
}

}  // namespace lichtenberg::effects
