#include "src/granular/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "solvers/error.hpp"
#include "src/effects/flat_walls.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/pair_state.hpp"
#include "src/theory/restitution.hpp"

namespace lichtenberg::granular {
namespace {

/// Sets GrainContact::alone to false for contacts of grains that are in more than one contact. `grains`: number of
/// grains.
void mark_shared_contacts(std::vector<StepContact>& step_contacts, int grains) {
  std::vector<int> touching(grains);
  for (const StepContact& entry : step_contacts) ++touching[entry.contact.pair.i], ++touching[entry.contact.pair.j];
  for (StepContact& entry : step_contacts)
    if (touching[entry.contact.pair.i] > 1 || touching[entry.contact.pair.j] > 1) entry.contact.alone = false;
}

/// Returns the new contact of a pair that moved from the separation `before` to `now` within a step of length dt from
/// the time `begin`. Its onset is where the distance is `reach` (sum of the radii) on the straight path between them.
template <int d>
GrainContact new_contact(Pair pair, Vec<d> before, Vec<d> now, double reach, double begin, double dt) {
  const Vec<d> displacement = now - before;
  const double b = dot(before, displacement), c = norm2(before) - reach * reach;
  const double part = c > 0 ? std::min(straight_onset(b, c, norm2(displacement)), 1.0) : 0;
  return {pair, begin + part * dt, closing(PairState<d>{before + part * displacement, displacement / dt})};
}

/// Constants of a viscoelastic contact, and the keys that give them: stiffness and damping, or young and viscosity.
struct ViscoelasticKeys {
  std::string table;
  double elastic = 0, dissipative = 0;
  std::optional<double> young, viscosity;
};

/// Throws InputError for damping beyond the table of theory::RestitutionCurve, which contact substeps do not resolve.
void check_damping(const Scene& scene, const ViscoelasticKeys& of) {
  const double number = theory::dissipation_number({of.elastic, of.dissipative}, 1);
  constexpr double most = theory::RestitutionCurve::largest;
  if (number <= most) return;
  const bool in_si = of.young && of.viscosity && scene.reference;
  const double per_damping = theory::dissipation_number({of.elastic, of.elastic}, 1) *
                             (in_si ? scene.reference->velocity / scene.reference->length : 1 / of.elastic);
  throw InputError(fmt::format(
      "{}: {}.{} = {:g} is too large for its {} = {:g}: at most {:.3g} is allowed, with which an impact at speed {} "
      "loses nearly all its energy",
      scene.path, of.table, in_si ? "viscosity" : "damping", in_si ? *of.viscosity : of.dissipative,
      in_si ? "young" : "stiffness", in_si ? *of.young : of.elastic, most / per_damping,
      scene.in_si ? fmt::format("{:.3g} m/s", scene.reference->velocity) : "1"));
}

/// Checks the damping of the contacts of viscoelastic grains and of those with walls.
void check_damping(const Scene& scene, const GrainContactLaw& law) {
  const auto* soft = std::get_if<ViscoelasticLaw>(&law);
  if (!soft) return;
  const auto [elastic, dissipative] = *soft;
  ViscoelasticKeys grains{"effects.viscoelastic_contact", elastic, dissipative, {}, {}};
  if (const auto* given = scene.effects.find<effects::ViscoelasticContactOptions>())
    grains.young = given->young, grains.viscosity = given->viscosity;
  check_damping(scene, grains);
  const auto* walls = scene.effects.find<effects::FlatWallsOptions>();
  if (!walls) return;
  check_damping(scene, {"effects.flat_walls", walls->stiffness.value_or(elastic), walls->damping.value_or(dissipative),
                        walls->young, walls->viscosity});
}

}  // namespace

void refuse_flight_through(const GrainContact& contact, double stiffer) {
  constexpr double margin = 1.1;  // the grains stop before that distance
  const std::string how = stiffer > 0 ? fmt::format("about {:.1f} times its stiffness would suffice", margin * stiffer)
                                      : std::string("a larger stiffness is needed");
  throw Failure(fmt::format(
      "grains {} and {} fly through each other after an impact at speed {:.3g}: the contact is too soft "
      "for it and for the other forces on them; {} (in a stage: equilibration.stiffness), or a lower temperature",
      contact.pair.i, contact.pair.j, contact.impact_speed, how));
}

void refuse_flight_through_wall(int grain, int side) {
  throw Failure(
      fmt::format("grain {} flies through the wall at the {} side: the contact is too soft for its speed and for the "
                  "forces on it; a larger stiffness of the walls (effects.flat_walls.stiffness, or young) is needed",
                  grain, side_names[side]));
}

GrainContactLaw contact_law(const Scene& scene, const Model& model) {
  const GrainContactLaw* law = nullptr;
  for (const auto& effect : model.effects)
    if (effect->grain_contact()) {
      if (law) throw InputError(scene.path + ": two effects define the contact force of grains: one is allowed");
      law = effect->grain_contact();
    }
  if (!law)
    throw InputError(scene.path +
                     ": a scene of grains needs effects.viscoelastic_contact or effects.linear_contact: without it "
                     "they would fly through each other");
  check_damping(scene, *law);
  return *law;
}

ContactLoad contact_load(const GrainContactLaw& law, const Bodies& bodies, std::span<const Pair> pairs) {
  ContactLoad load{.force = std::vector<double>(bodies.momentum.size())};
  const auto add = [&]<int d>(const auto& one, const Spheres<d>& grains, Pair pair) {
    const auto [i, j] = pair;
    const PairState<d> state = pair_state(bodies, grains, pair);
    const double distance = norm(state.separation), overlap = reach(bodies, pair) - distance;
    if (overlap <= 0) return;
    const ContactForce contact =
        contact_at(one, overlap, closing(state), one.scale(bodies.radius[i], bodies.radius[j]));
    load.dissipation += contact.dissipated;
    const Vec<d> force = (contact.force / distance) * state.separation;
    for (int k = 0; k < d; ++k) load.force[i * d + k] -= force[k], load.force[j * d + k] += force[k];
  };
  std::visit(
      [&](const auto& one) {
        visit_spheres(bodies, [&](const auto& grains) {
          for (const Pair pair : pairs) add(one, grains, pair);
        });
      },
      law);
  return load;
}

namespace {

/// Calls use(pair, elastic energy) for each contact with an overlap.
template <class Use>
void visit_stored(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts,
                  const Use& use) {
  const auto visit = [&](const auto& one, const auto& grains) {
    for (const GrainContact& contact : contacts) {
      const auto [i, j] = contact.pair;
      const double overlap = reach(bodies, contact.pair) - norm(separation(grains, contact.pair));
      if (overlap > 0) use(contact.pair, one.parts(overlap, one.scale(bodies.radius[i], bodies.radius[j])).stored);
    }
  };
  std::visit([&](const auto& one) { visit_spheres(bodies, [&](const auto& grains) { visit(one, grains); }); }, law);
}

}  // namespace

double stored_energy(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts) {
  double energy = 0;
  visit_stored(law, bodies, contacts, [&](Pair, double stored) { energy += stored; });
  return energy;
}

double fastest_release(const GrainContactLaw& law, const Bodies& bodies, std::span<const GrainContact> contacts) {
  double square = 0;
  visit_stored(law, bodies, contacts,
               [&](Pair pair, double stored) { square = std::max(square, 2 * stored / reduced_mass(bodies, pair)); });
  return std::sqrt(square);
}

std::vector<StepContact> contacts_in_step(std::span<const double> from, const Bodies& bodies,
                                          std::span<const GrainContact> contacts, std::span<const Pair> pairs,
                                          double begin, double dt) {
  std::vector<StepContact> step_contacts;
  auto contact = contacts.begin();
  visit_spheres(bodies, [&]<int d>(const Spheres<d>& grains) {
    const Spheres<d> then{from, bodies.radius, grains.box};
    for (const Pair pair : pairs) {
      while (contact != contacts.end() && contact->pair < pair) ++contact;
      const bool old = contact != contacts.end() && contact->pair == pair;
      const Vec<d> now = separation(grains, pair);
      const bool open = norm(now) < reach(bodies, pair);
      if (old)
        step_contacts.push_back({*contact, false, open});
      else if (open)
        step_contacts.push_back(
            {new_contact(pair, separation(then, pair), now, reach(bodies, pair), begin, dt), true, true});
    }
  });
  return step_contacts;
}

void note(std::vector<StepContact> step_contacts, const Bodies& bodies, double end, std::vector<GrainContact>& contacts,
          ContactRecord& record) {
  mark_shared_contacts(step_contacts, bodies.size());
  contacts.clear();
  visit_spheres(bodies, [&]<int d>(const Spheres<d>& grains) {
    for (const auto& [contact, begun, open] : step_contacts) {
      if (begun) record.begun.push_back(contact);
      const PairState<d> state = pair_state(bodies, grains, contact.pair);
      const double distance = norm(state.separation), sum = reach(bodies, contact.pair);
      record.largest_overlap = std::max(record.largest_overlap, (sum - distance) / sum);
      if (distance < too_close * sum) refuse_flight_through(contact);
      if (open)
        contacts.push_back(contact);
      else
        record.ended.push_back({contact, -closing(state), end, speed_across(state)});
    }
  });
}

}  // namespace lichtenberg::granular
