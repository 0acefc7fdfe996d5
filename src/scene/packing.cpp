#include "src/scene/packing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "solvers/geometry/box.hpp"
#include "solvers/network/electrode.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/loads.hpp"

namespace lichtenberg {
namespace {

std::string at(const Conductor& conductor, int dimension) {
  return dimension == 3
             ? fmt::format("[{:g}, {:g}, {:g}]", conductor.position.x, conductor.position.y, conductor.position.z)
             : fmt::format("[{:g}, {:g}]", conductor.position.x, conductor.position.y);
}

/// Returns the line of the [[conductor]] or [[population]] that defines particle i.
int line_of(const Draft& draft, std::size_t i) {
  if (i < draft.conductors.size()) return draft.conductors[i].line;
  i -= draft.conductors.size();
  for (const PopulationDraft& population : draft.populations) {
    if (i < static_cast<std::size_t>(population.count)) return population.line;
    i -= population.count;
  }
  return 0;
}

std::vector<Wall> sides_of_box(const Domain& domain, int dimension) {
  std::vector<Wall> walls;
  for (int k = 0; k < dimension; ++k) {
    if (domain.box().periodic(k)) continue;
    Wall low{.name = std::string(side_names[2 * k])},
        high{.name = std::string(side_names[2 * k + 1]), .point = domain.size};
    low.normal[k] = 1, high.normal[k] = -1;
    walls.push_back(low), walls.push_back(high);
  }
  return walls;
}

Wall build_wall(const Draft& draft, const WallDraft& given, std::size_t number) {
  const Vec3 n = given.normal.value;
  const double length = std::hypot(n.x, n.y, n.z);
  if (length == 0)
    refuse(draft.scene.path, given.line, "wall.normal = 0 is not allowed: it must point to the particles' side");
  if (given.name && !network::is_electrode_name(*given.name))
    refuse(draft.scene.path, given.line,
           fmt::format("wall.name = \"{}\" is not allowed: it must not be a number, which names a particle, nor "
                       "`all`, which names all of them, nor have a comma in it or a blank at its ends",
                       *given.name));
  return {given.name.value_or(fmt::format("wall {}", number)), given.point.value, n / length};
}

void check_content(const Scene& scene) {
  const bool spheres = scene.dimension() == 3;
  const double filled = packing_fraction(scene);
  if (filled > 1)
    refuse(scene.path, 0,
           fmt::format("the particles cannot fit: their total {0} is {1:.3g} times that of the domain, and at most 1 "
                       "is allowed; use fewer or smaller ones, or a larger domain.size",
                       spheres ? "volume" : "area", filled));
}

/// Throws InputError for two centres at the same position, between which the force has no direction. Positions are
/// sorted along x, so equal ones are neighbours.
void check_distinct_positions(const Draft& draft, const Scene& scene) {
  std::vector<std::size_t> order(scene.conductors.size());
  std::iota(order.begin(), order.end(), 0);
  const auto coordinates = [&](std::size_t i) {
    const Conductor& c = scene.conductors[i];
    return std::tuple(c.position.x, c.position.y, c.position.z);
  };
  std::ranges::sort(order, {}, coordinates);
  const auto same = std::ranges::adjacent_find(order, {}, coordinates);
  if (same != order.end())
    refuse(scene.path, line_of(draft, *same),
           fmt::format("two particles are at {} m, where their energy is infinite: their positions must differ",
                       at(scene.conductors[*same], scene.dimension())));
}

/// Throws InputError for keys that have no effect in a packing.
void check_ignored_keys(const Draft& draft) {
  const std::string uncharged = "nothing is charged", timeless = "nothing happens in time";
  struct IgnoredKey {
    std::string key, why, instead;
  };
  const std::string side_remedy =
      "leave it out, or make it periodic; the sides are walls unless effects.soft_repulsion.box = false";
  const std::vector<IgnoredKey> all = {
      {"domain.left", uncharged, side_remedy},
      {"domain.right", uncharged, side_remedy},
      {"domain.bottom", uncharged, side_remedy},
      {"domain.top", uncharged, side_remedy},
      {"domain.front", uncharged, side_remedy},
      {"domain.back", uncharged, side_remedy},
      {"medium", "there is no fluid", "leave it out"},
      {"material", "nothing has a mass", "leave it out, or add the table [effects.gravity]"},
      {"field", uncharged, "leave it out"},
      {"mechanics", timeless, "[minimize] says how the particles come to rest"},
      {"stop", timeless, "minimize.force_tolerance and minimize.max_iterations say when it ends"},
      {"output.every", timeless, "minimize.record_every says how many iterations lie between frames"},
      {"conductor.charge", uncharged, "leave it out"},
      {"conductor.velocity", timeless, "leave it out"},
      {"population.charge", uncharged, "leave it out"},
  };
  const auto has_a_use = [&](const std::string& key) {
    const auto side =
        std::ranges::find_if(side_names, [&](std::string_view s) { return key == fmt::format("domain.{}", s); });
    if (side != side_names.end()) return draft.scene.domain.sides[side - side_names.begin()].periodic;
    return key == "material" && draft.scene.effects.has("gravity");
  };
  for (const IgnoredKey& ignored : all)
    if (!has_a_use(ignored.key))
      refuse_if_given(
          draft, ignored.key,
          fmt::format("is not allowed with effects.soft_repulsion, under which {}: {}", ignored.why, ignored.instead));
}

bool all_periodic(const Domain& domain, int dimension) {
  for (int k = 0; k < dimension; ++k)
    if (!domain.box().periodic(k)) return false;
  return true;
}

}  // namespace

void check_packing_keys(const Draft& draft) {
  check_load_keys(draft);
  const auto refuse_it = [&](int line, const std::string& message) { refuse(draft.scene.path, line, message); };
  if (!draft.scene.effects.has(&EffectKind::packing)) {
    const std::string needs = " needs the table [effects.soft_repulsion]: add it, or leave this out";
    if (!draft.walls.empty()) refuse_it(draft.walls.front().line, "[[wall]]" + needs);
    refuse_if_given(draft, "minimize", needs.substr(1));
    for (const PopulationDraft& population : draft.populations)
      if (population.overlapping) refuse_it(population.line, "population.overlapping" + needs);
    return;
  }
  const std::string why = " is not allowed with effects.soft_repulsion, in which nothing is charged: leave one out";
  check_ignored_keys(draft);
  const MinimizeMethod method = draft.scene.minimize.method;
  if (method != MinimizeMethod::gradient_descent)
    refuse_if_given(
        draft, "minimize.step",
        fmt::format("is not allowed with minimize.method = \"{}\", which chooses its steps: leave it out, or "
                    "choose \"gradient-descent\"",
                    name_of(method)));
  if (!draft.electrodes.empty()) refuse_it(draft.electrodes.front().line, "[[electrode]]" + why);
  if (!draft.groups.empty()) refuse_it(draft.groups.front().line, "[[group]]" + why);
}

std::vector<Wall> build_walls(const Draft& draft) {
  const Scene& scene = draft.scene;
  if (!scene.effects.has(&EffectKind::packing)) return {};
  std::vector<Wall> walls;
  if (scene.domain.walled) walls = sides_of_box(scene.domain, scene.dimension());
  for (std::size_t k = 0; k < draft.walls.size(); ++k) walls.push_back(build_wall(draft, draft.walls[k], k + 1));
  if (walls.empty() && !all_periodic(scene.domain, scene.dimension()))
    refuse(scene.path, draft.line("effects.soft_repulsion.box"),
           "the packing has no walls: effects.soft_repulsion.box = true, at least one [[wall]] or periodic sides are "
           "needed");
  std::set<std::string> names;
  for (const Wall& wall : walls)
    if (!names.insert(wall.name).second)
      refuse(scene.path, draft.line("wall"),
             fmt::format("wall.name = \"{}\" is taken: the names of walls must differ", wall.name));
  return walls;
}

void check_packing(const Draft& draft, const Scene& scene) {
  const int dimension = scene.dimension();
  check_content(scene);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const Conductor& c = scene.conductors[i];
    for (const Wall& wall : scene.walls)
      if (!(distance(wall, c) > 0))
        refuse(scene.path, line_of(draft, i),
               fmt::format("the particle at {} m is not allowed: its centre is not inside the wall \"{}\"",
                           at(c, dimension), wall.name));
    double narrowest = INFINITY;
    for (int k = 0; k < dimension; ++k)
      if (!scene.domain.box().periodic(k)) narrowest = std::min(narrowest, scene.domain.size[k]);
    if (scene.domain.walled && c.radius > narrowest)
      refuse(scene.path, line_of(draft, i),
             fmt::format("a particle of radius {:g} m cannot fit between walls that are {:g} m apart: even the "
                         "radius is larger than that",
                         c.radius, narrowest));
  }
  check_distinct_positions(draft, scene);
}

}  // namespace lichtenberg
