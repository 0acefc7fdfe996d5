#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/error.hpp"
#include "solvers/network/electrode.hpp"
#include "solvers/network/resistor.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/circuits.hpp"
#include "src/scene/draft.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/electrodes.hpp"
#include "src/scene/freeform.hpp"
#include "src/scene/grains.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/packing.hpp"
#include "src/scene/placing.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg {
namespace {

/// Throws InputError if an effect that must be the only one is combined with another.
void check_alone(const Draft& draft) {
  for (const Effects::Entry& entry : draft.scene.effects)
    for (const Effects::Entry& other : draft.scene.effects)
      if (!entry.kind->alone.empty() && entry.kind != other.kind && other.kind->name != entry.kind->beside)
        refuse(draft.scene.path, draft.line("effects." + other.kind->name),
               fmt::format("effects.{} is not allowed with effects.{}, {}: leave one out", other.kind->name,
                           entry.kind->name, entry.kind->alone));
}

void check_effects(const Draft& draft) {
  const Effects& effects = draft.scene.effects;
  for (const Effects::Entry& entry : effects)
    for (const NeededEffect& needed : entry.kind->needs)
      if (!effects.has(needed.name))
        refuse_effect(
            draft, entry.kind->name,
            fmt::format("the table [effects.{}]{}{}", needed.name, needed.why.empty() ? "" : ", ", needed.why));
  for (const Effects::Entry& entry : effects)
    if (entry.kind->check) entry.kind->check(draft);
}

/// Throws InputError for an electrode behind a resistor in a scene without a field. Such an electrode has a charge of
/// its own.
void check_series_resistances(const Draft& draft) {
  const auto behind_resistor =
      std::ranges::find_if(draft.electrodes, [](const auto& e) { return e.series_resistance.has_value(); });
  if (behind_resistor != draft.electrodes.end() && !draft.scene.effects.has(&EffectKind::field))
    refuse(draft.scene.path, behind_resistor->line,
           "electrode.series_resistance needs the table [effects.floating_conductors]: add it, or leave the key out");
}

/// Throws InputError for materials of conductors and populations in scenes without elastic contacts. Only contacts use
/// materials.
void check_materials(const Draft& draft) {
  if (draft.scene.effects.has("hertz_contact") || draft.scene.effects.has("wall_contact")) return;
  for (const char* key : {"conductor.young", "conductor.poisson", "population.young", "population.poisson"})
    refuse_if_given(
        draft, key,
        "needs the table [effects.hertz_contact] or [effects.wall_contact]: add one of them, or leave the key "
        "out");
}

double permittivity(const Draft& draft) {
  if (draft.permittivity && draft.relative_permittivity)
    refuse(draft.scene.path, draft.line("medium.permittivity"),
           "medium.permittivity and medium.relative_permittivity are both given: only one of them is allowed");
  if (draft.relative_permittivity) return *draft.relative_permittivity * vacuum_permittivity;
  return draft.permittivity.value_or(0);
}

/// Returns true if `cells` cells along the longer side give a whole number along the shorter side.
bool fits(Vec3 size, int cells) {
  const double across = cells * std::min(size.x, size.y) / std::max(size.x, size.y), whole = std::round(across);
  constexpr double rounding = 1e-9;  // rounding of sides written as decimal numbers
  return whole >= 1 && std::abs(across - whole) <= rounding * whole;
}

/// Returns the first number of cells that fits the box, from `cells` in steps of `step`, within a factor of two; 0:
/// none.
int nearest_that_fits(Vec3 size, int cells, int step) {
  for (int n = cells; n >= cells / 2 && n <= 2 * cells && n > 0; n += step)
    if (fits(size, n)) return n;
  return 0;
}

/// Describes alternatives to a number of cells that does not fit.
std::string fitting(Vec3 size, int cells) {
  const int fewer = nearest_that_fits(size, cells, -1), more = nearest_that_fits(size, cells, 1);
  if (fewer > 0 && more > 0) return fmt::format("field.cells = {} or {} would do", fewer, more);
  if (fewer > 0 || more > 0) return fmt::format("field.cells = {} would do", std::max(fewer, more));
  const double h = std::max(size.x, size.y) / cells;
  return fmt::format("{:.12g} m would do", std::max(1.0, std::round(std::min(size.x, size.y) / h)) * h);
}

/// Returns the number of cells along the longer side such that cells are square. It is the given number, or the default
/// or a slightly larger one.
int fitting_cells(const Draft& draft) {
  const Vec3 size = draft.scene.domain.size;
  const int cells = draft.field.options.cells;
  if (draft.field.accuracy || fits(size, cells)) return cells;  // for an accuracy, the number is chosen later
  const int more = draft.line("field.cells") > 0 ? 0 : nearest_that_fits(size, cells, 1);
  if (more > 0) return more;
  refuse(draft.scene.path, draft.line("domain.size"),
         fmt::format("domain.size = [{:g}, {:g}] m does not give square cells: with field.cells = {} along the longer "
                     "side the shorter one would have {:g}, which must be a whole number; {}",
                     size.x, size.y, cells, cells * std::min(size.x, size.y) / std::max(size.x, size.y),
                     fitting(size, cells)));
}

/// Throws InputError for keys that field.accuracy replaces, and for methods without an error estimate.
void check_accuracy(const Draft& draft) {
  const FieldDraft& field = draft.field;
  if (!field.accuracy) return;
  for (const std::string key : {"field.cells", "field.tolerance", "field.moving_tolerance"})
    refuse_if_given(draft, key, "is chosen for field.accuracy: leave one of the two out");
  const auto refuse_with = [&](const std::string& key, const std::string& value, const std::string& why) {
    refuse(draft.scene.path, draft.line(key),
           fmt::format("{} = \"{}\" is not allowed with field.accuracy: {}", key, value, why));
  };
  const auto estimates = [](const FieldMethodKind& method) { return method.accuracy.has_value(); };
  if (field.method && field.method->solves(2) && !estimates(*field.method))
    refuse_with("field.method", field.method->name,
                fmt::format("its error is not estimated; {} are allowed", field_methods_that(2, estimates)));
  if (field.options.links != FieldLinks::log_fitted)
    refuse_with("field.boundary_stencil", name_of(field.options.links), "\"log-fitted\" needs fewer cells");
}

void fill_in_tolerances(const Draft& draft, FieldOptions& field) {
  const FieldTolerances& method = field.method->tolerance;
  const auto fill_in = [&](const std::string& key, std::optional<double> given, double usual, double& value) {
    value = given.value_or(usual);
    if (value < method.least)
      refuse(draft.scene.path, draft.line(key),
             fmt::format(
                 "{} = {:g} is not allowed: it must be at least {:g}, because of rounding, with field.method = \"{}\"",
                 key, value, method.least, field.method->name));
  };
  fill_in("field.tolerance", draft.field.tolerance, method.single, field.tolerance);
  fill_in("field.moving_tolerance", draft.field.moving_tolerance, method.moving, field.moving_tolerance);
}

/// Returns the method that the scene names, or the default one; null: still to be chosen.
const FieldMethodKind* method_of(const Draft& draft) {
  if (draft.field.method || (draft.field.accuracy && draft.scene.dimension() == 2)) return draft.field.method;
  return &usual_field_method(draft.scene.dimension());
}

/// Throws InputError for keys of [field] that the method does not take.
void check_field_keys(const Draft& draft) {
  const FieldMethodKind* method = method_of(draft);
  if (!method || !draft.scene.effects.has(&EffectKind::field)) return;
  for (const std::string key : {"cells", "threads", "boundary_stencil", "linear_solver", "relaxation_eta"}) {
    const int line = draft.line("field." + key);
    if (line == 0 || method->takes(key)) continue;
    const std::string others =
        field_methods_that(draft.scene.dimension(), [&](const FieldMethodKind& other) { return other.takes(key); });
    refuse(draft.scene.path, line,
           fmt::format("field.{} is not allowed with field.method = \"{}\": methods that take it are {}", key,
                       method->name, others));
  }
}

/// Returns [field] with its defaults.
FieldTable field_of(const Draft& draft, int cells) {
  const FieldDraft& given = draft.field;
  FieldOptions options = given.options;
  options.cells = cells;
  if (draft.scene.dimension() == 3) {
    options.method = method_of(draft);
    fill_in_tolerances(draft, options);
    if (!given.accuracy) return options;
    options.tolerance = options.moving_tolerance = *given.accuracy;  // effects::with_field_chosen may reduce it
    options.chosen_for = {.requested = *given.accuracy, .estimate = *given.accuracy};
    return options;
  }
  if (given.accuracy)
    return FieldRequest{.accuracy = *given.accuracy,
                        .method = given.method,
                        .device = options.device,
                        .threads = options.threads,
                        .linear_solver = options.linear_solver};
  options.method = method_of(draft);
  options.relaxation_eta = given.relaxation_eta.value_or(0);
  fill_in_tolerances(draft, options);
  return options;
}

void check_resolution(const Draft& draft, double smallest_radius, double h) {
  if (!draft.field.method) return;
  const double least = draft.field.method->least_radius * h;
  if (smallest_radius < least)
    refuse(
        draft.scene.path, draft.line("field.method"),
        fmt::format("field.method = \"{}\" needs a radius of at least {:.3g} m with these cells, but the smallest is "
                    "{:.3g} m: field.cells must be at least {:.0f}",
                    draft.field.method->name, least, smallest_radius,
                    std::ceil(draft.field.options.cells * least / smallest_radius)));
}

int group_index(const Draft& draft, const ConductorDraft& conductor) {
  const auto found = std::ranges::find(draft.groups, *conductor.group, &GroupDraft::name);
  if (found != draft.groups.end()) return static_cast<int>(found - draft.groups.begin());
  std::vector<std::string> names;
  for (const GroupDraft& group : draft.groups) names.push_back(group.name);
  refuse(draft.scene.path, conductor.line,
         fmt::format("conductor.group = \"{}\" is unknown: {}", *conductor.group,
                     names.empty() ? "the scene has no [[group]]"
                                   : fmt::format("the nearest [[group]] is \"{}\"", nearest(*conductor.group, names))));
}

std::vector<PrescribedGroup> build_groups(const Draft& draft) {
  // Checks names first, so that a misspelt name is reported as unknown, not the intended group as empty.
  for (const ConductorDraft& conductor : draft.conductors)
    if (conductor.group) group_index(draft, conductor);
  std::vector<PrescribedGroup> groups;
  std::set<std::string> names;
  for (const GroupDraft& group : draft.groups) {
    const auto refuse_it = [&](const std::string& why) {
      refuse(draft.scene.path, group.line, fmt::format("the group \"{}\" {}", group.name, why));
    };
    if (!names.insert(group.name).second) refuse_it("is defined twice: the names of groups must differ");
    if (group.charge && group.potential) refuse_it("has both a charge and a potential: only one of them is allowed");
    if (!group.charge && !group.potential && group.circuit < 0)
      refuse_it("has neither a charge in C nor a potential in V, and is in no circuit: one of them is needed");
    const bool used = std::ranges::any_of(draft.conductors, [&](const auto& c) { return c.group == group.name; });
    if (!used) refuse_it("has no conductors: at least one [[conductor]] must name it");
    groups.push_back({group.name, group.charge.value_or(0), group.potential, group.circuit});
  }
  return groups;
}

/// Sets charges and groups of the individually given conductors, which come first.
void assign_groups(const Draft& draft, Scene& scene) {
  for (std::size_t i = 0; i < draft.conductors.size(); ++i) {
    const ConductorDraft& conductor = draft.conductors[i];
    scene.conductors[i].charge = conductor.charge.value_or(0);
    if (!conductor.group) continue;
    scene.conductors[i].group = group_index(draft, conductor);
    if (conductor.charge)
      refuse(draft.scene.path, conductor.line,
             fmt::format("conductor.charge = {:g} C is not allowed for a member of the group \"{}\": the charge is the "
                         "group's",
                         *conductor.charge, *conductor.group));
  }
}

std::vector<std::string> names_of_walls(const Scene& scene) {
  if (!scene.effects.has(&EffectKind::packing)) return {side_names.begin(), side_names.begin() + 2 * scene.dimension()};
  std::vector<std::string> names;
  for (const Wall& wall : scene.walls) names.push_back(wall.name);
  return names;
}

/// Throws InputError for networks that cannot be measured, so that the run does not end without them.
void check_network(const Draft& draft, const Scene& scene) {
  if (draft.line("network") == 0) return;
  const NetworkOptions& options = scene.network;
  const auto check = [&](const std::string& key, const auto& work) {
    try {
      work();
    } catch (const InputError& error) {
      refuse(scene.path, draft.line(key), key + ": " + error.what());
    }
  };
  const network::ResistorModel& model = network::resistor_model(options.resistor.value_or("constant"));
  for (const network::ParameterEntry& entry : network::parameter_entries())
    if (const std::string key = std::string("network.") + entry.name; draft.line(key) > 0 && !uses(model, entry))
      refuse(scene.path, draft.line(key),
             fmt::format("{} is not allowed: the resistor model \"{}\" does not use it; it needs {}", key, model.name,
                         parameters_in_words(model)));
  if (options.resistor) check("network.resistor", [&] { network::check(model, options.parameters); });
  if (model.uses_force && !scene.effects.has(&EffectKind::packing))
    refuse(scene.path, draft.line("network.resistor"),
           fmt::format("network.resistor = \"{}\" needs the forces of contacts, which only packings "
                       "(effects.soft_repulsion) have: \"overlap\" takes the overlaps of other scenes",
                       model.name));
  if (options.model == NetworkModel::particle && model.path == nullptr)
    refuse(
        scene.path, draft.line("network.model"),
        fmt::format("network.model = \"particle\" is not allowed with network.resistor = \"{}\", a model of contacts "
                    "on a particle: it must be \"contact\"",
                    model.name));
  std::vector<double> radius;
  for (const Conductor& conductor : scene.conductors) radius.push_back(conductor.radius);
  check(model.flat && scene.dimension() == 3 ? "network.resistor" : "network.contact_radius",
        [&] { network::check_particles(model, options.parameters, radius, scene.dimension()); });
  if (draft.line("network.terminals") > 0)
    check("network.terminals", [&] {
      network::read_electrodes(options.between, names_of_walls(scene), static_cast<int>(scene.conductors.size()));
    });
}

/// Throws InputError if frames are so frequent that rounding merges their times.
void check_frames(const Draft& draft) {
  constexpr double most = 1e9;
  const double every = draft.scene.output.every, time = draft.scene.stop.time;
  if (every * most < time)
    refuse(draft.scene.path, draft.line("output.every"),
           fmt::format(
               "output.every = {0:g} {4} is not allowed: up to stop.time = {1:g} {4} that makes {2:.2g} frames, and "
               "at most {3:g} are allowed",
               every, time, time / every, most, draft.scene.units().time));
}

/// Throws InputError for a scene without conductors, unless the field is its only effect and an electrode exists.
void check_empty(const Draft& draft, const Scene& scene) {
  const bool field_alone = scene.effects.has(&EffectKind::field) &&
                           std::ranges::all_of(scene.effects, [](const auto& entry) { return entry.kind->field; });
  if (!field_alone)
    refuse(scene.path, 0,
           "the scene has no conductors: at least one [[conductor]] or [[population]] is needed, except if "
           "[effects.floating_conductors] is the only effect and there are electrodes");
  const bool any_side = std::ranges::any_of(scene.domain.sides, &DomainSide::electrode);
  if (scene.electrodes.empty() && !any_side)
    refuse(scene.path, draft.line("domain"), "the scene has neither conductors nor electrodes: there is no field");
}

void check_fixed(const Draft& draft, bool can_be_fixed) {
  for (const ConductorDraft& conductor : draft.conductors) {
    if (!conductor.conductor.fixed) continue;
    if (!can_be_fixed)
      refuse(draft.scene.path, conductor.line, "conductor.fixed is only for motions of conductors in time");
    if (conductor.velocity)
      refuse(draft.scene.path, conductor.line, "conductor.velocity is not allowed with conductor.fixed");
  }
}

/// Throws InputError unless the position tolerance is at least touching_slack of the smallest radius and at least the
/// rounding of positions. Positions that differ by less than the first count as equal when the scene is read. Positions
/// are rounded to 2.2e-16 of the domain.
void check_position_tolerance(const Draft& draft, double smallest_radius) {
  const Vec3 size = draft.scene.domain.size;
  const double least = std::max(touching_slack * smallest_radius,
                                std::numeric_limits<double>::epsilon() * std::max({size.x, size.y, size.z}));
  const double most = std::max({size.x, size.y, size.z}), given = draft.position_tolerance.value_or(least);
  if (given > most)
    refuse(draft.scene.path, draft.line("mechanics.position_tolerance"),
           fmt::format("mechanics.position_tolerance = {:g} m is not allowed: it must be at most {:g} m, the domain's "
                       "longest side",
                       given, most));
  if (given >= least) return;
  refuse(draft.scene.path, draft.line("mechanics.position_tolerance"),
         fmt::format("mechanics.position_tolerance = {:g} m is not allowed: it must be at least {:.2g} m, which is "
                     "{:g} of the smallest radius or the rounding of the domain's size",
                     *draft.position_tolerance, least, touching_slack));
}

/// Throws InputError for bodies smaller than finest_diameter of the domain. Gaps and overlaps are differences of
/// positions, which are rounded to 2.2e-16 of the domain. This is 2e-7 of the smallest diameter. Overlaps of grains, a
/// few per cent of a diameter, then have a relative rounding error of 1e-5.
void check_size(const Draft& draft, double smallest_radius) {
  const Vec3 size = draft.scene.domain.size;
  const double longest = std::max({size.x, size.y, size.z});
  if (2 * smallest_radius >= finest_diameter * longest) return;
  refuse(draft.scene.path, draft.line("domain.size"),
         fmt::format("domain.size = {0:g} {3} along its longest side is not allowed with a {4} of diameter {1:g} {3}: "
                     "at most {2:g} times that is, or {5} would be lost in rounding",
                     longest, 2 * smallest_radius, 1 / finest_diameter, draft.scene.units().length,
                     draft.scene.reference ? "grain" : "conductor", draft.scene.reference ? "contacts" : "gaps"));
}

/// Limits the longest step to that which resolves a function of time (s). Throws InputError if the file gives a longer
/// one.
void limit_step(const Draft& draft, double longest, Scene& scene) {
  if (draft.largest_step && *draft.largest_step > longest)
    refuse(
        scene.path, draft.line("mechanics.largest_step"),
        fmt::format("mechanics.largest_step = {:g} s is not allowed: it must be at most {:g} s, 1/20 of the period of "
                    "a source",
                    *draft.largest_step, longest));
  scene.mechanics.largest_step = std::min(scene.mechanics.largest_step, longest);
}

void fill_in_defaults(const Draft& draft, Scene& scene, double smallest_radius, double largest_radius) {
  scene.medium = {.permittivity = permittivity(draft),
                  .viscosity = draft.viscosity.value_or(0),
                  .depth = draft.depth.value_or(largest_radius > 0 ? 2 * largest_radius : 1),
                  .temperature = scene.medium.temperature};
  scene.mechanics.position_tolerance = draft.position_tolerance.value_or(1e-3 * smallest_radius);
  scene.mechanics.largest_step = draft.largest_step.value_or(scene.output.every);
  for (const Signal& signal : varying_signals(scene)) limit_step(draft, signal.longest_step(), scene);
  scene.output.file = draft.output_file.value_or(std::filesystem::path(scene.path).stem().string() + ".h5");
}

}  // namespace

Scene complete(const Draft& draft, const StopRequest& stop, const std::vector<Conductor>& bodies) {
  check_alone(draft);
  check_grains(draft);
  check_packing_keys(draft);
  check_effects(draft);
  check_series_resistances(draft);
  check_materials(draft);
  check_accuracy(draft);
  check_field_keys(draft);
  Scene scene = draft.scene;
  const bool packing = scene.effects.has(&EffectKind::packing);
  scene.seed = static_cast<std::uint64_t>(draft.seed);
  scene.electrodes = build_electrodes(draft);
  scene.walls = build_walls(draft);
  scene.groups = build_groups(draft);
  if (!packing) check_given_conductors(draft, scene.electrodes);
  const FieldMethodKind* method = method_of(draft);
  const bool has_no_field = (method && !method->takes("cells")) || packing || scene.reference ||
                            scene.dimension() == 3 || scene.domain.box().any_periodic();
  const int cells = has_no_field ? draft.field.options.cells : fitting_cells(draft);
  const double h = has_no_field ? 0 : std::max(scene.domain.size.x, scene.domain.size.y) / cells;
  const bool empty = draft.conductors.empty() && draft.populations.empty();
  if (empty) check_empty(draft, scene);
  check_fixed(draft, !packing && !scene.reference);
  if (!empty)
    scene.conductors =
        bodies.empty() ? place_conductors(draft, scene.electrodes, scene.walls, stop) : conductors_at(draft, bodies);
  assign_groups(draft, scene);
  if (scene.reference) complete_grains(draft, scene);
  const auto [smallest, largest] =
      empty ? std::ranges::minmax_result<Conductor>{} : std::ranges::minmax(scene.conductors, {}, &Conductor::radius);
  if (!empty) {
    check_size(draft, smallest.radius);
    check_resolution(draft, smallest.radius, h);
    check_position_tolerance(draft, smallest.radius);
  }
  scene.field_table = field_of(draft, cells);
  fill_in_defaults(draft, scene, smallest.radius, largest.radius);
  for (const Effects::Entry& entry : draft.scene.effects)
    if (entry.kind->complete) entry.kind->complete(draft, scene);
  if (scene.reference) fill_in_steps(draft, scene);
  if (packing) check_packing(draft, scene);
  check_frames(draft);
  check_network(draft, scene);
  if (draft.field.method && draft.field.method->only_disks) check_disks_only(draft, scene.electrodes);
  check_freeforms(draft, scene.electrodes);
  return scene;
}

}  // namespace lichtenberg
