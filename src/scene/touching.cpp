#include "src/scene/touching.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include <fmt/format.h>

#include "solvers/geometry/box.hpp"

#include "src/scene/electrodes.hpp"
#include "src/scene/placing.hpp"

namespace lichtenberg {
namespace {

std::optional<Signal> potential_of(const Scene& scene, const Conductor& conductor) {
  return conductor.group < 0 ? std::nullopt : scene.groups[conductor.group].potential;
}

bool one_potential(const Scene& scene, const Conductor& a, const Conductor& b) {
  const std::optional<Signal> potential = potential_of(scene, a);
  const auto circuit = [&](const Conductor& c) { return c.group < 0 ? -1 : scene.groups[c.group].circuit; };
  if (circuit(a) >= 0 && circuit(a) == circuit(b)) return true;
  return (a.group >= 0 && a.group == b.group) || (potential && potential == potential_of(scene, b));
}

double gap(const Conductor& a, const Conductor& b, const Box<3>& box) {
  return norm(box.difference(a.position, b.position)) - b.radius - a.radius;
}

std::string position_text(const Scene& scene, const Conductor& conductor) {
  const Vec3 p = conductor.position;
  return scene.dimension() == 3 ? fmt::format("[{:g}, {:g}, {:g}]", p.x, p.y, p.z)
                                : fmt::format("[{:g}, {:g}]", p.x, p.y);
}

/// Checks pairs with a sweep along x: only pairs with overlapping extents along x are compared. On a periodic x axis
/// the sweep continues with the images beyond the right side.
void check_pairs(const Draft& draft, const Scene& scene, const auto& refuse_it) {
  std::vector<std::size_t> order(draft.conductors.size());
  std::iota(order.begin(), order.end(), 0);
  const auto left_end = [&](std::size_t i) { return scene.conductors[i].position.x - scene.conductors[i].radius; };
  std::ranges::sort(order, {}, left_end);
  const Box<3> box = scene.domain.box();
  const std::size_t n = order.size();
  for (std::size_t a = 0; a < n; ++a) {
    const Conductor& one = scene.conductors[order[a]];
    const double slack = touching_slack * one.radius, reach = one.position.x + one.radius + slack;
    for (std::size_t k = a + 1; k < (box.periodic(0) ? a + n : n); ++k) {
      const std::size_t b = order[k % n];
      if (left_end(b) + (k < n ? 0 : box.lengths.x) > reach) break;
      const Conductor& other = scene.conductors[b];
      if (gap(one, other, box) <= slack && !one_potential(scene, one, other))
        refuse_it(order[a],
                  fmt::format("the one at {} m (line {})", position_text(scene, other), draft.conductors[b].line));
    }
  }
}

}  // namespace

void check_touching(const Draft& draft, const Scene& scene) {
  const auto refuse_it = [&](std::size_t i, const std::string& other) {
    refuse(
        scene.path, draft.conductors[i].line,
        fmt::format(
            "conductor.position = {} m is not allowed: this conductor touches {}, and the force between two potentials "
            "that touch has no limit; leave a gap, or connect them by [effects.contact_discharge] or a [[group]]",
            position_text(scene, scene.conductors[i]), other));
  };
  check_pairs(draft, scene, refuse_it);
  const Vec3 size = scene.domain.size;
  for (std::size_t i = 0; i < draft.conductors.size(); ++i) {
    const Conductor& conductor = scene.conductors[i];
    const Vec3 p = conductor.position;
    const double slack = touching_slack * conductor.radius;
    const std::optional<Signal> potential = potential_of(scene, conductor);
    const int circuit = conductor.group < 0 ? -1 : scene.groups[conductor.group].circuit;
    const auto is_joined = [&](const auto& terminal) {
      return terminal.circuit >= 0 ? terminal.circuit == circuit : potential == terminal.potential;
    };
    for (const Electrode& electrode : scene.electrodes)
      if (gap(conductor, electrode, scene.domain) <= slack &&
          (electrode.series_resistance > 0 || !is_joined(electrode)))
        refuse_it(i, fmt::format("the electrode \"{}\"", electrode.name));
    const std::array distance = {p.x, size.x - p.x, p.y, size.y - p.y, p.z, size.z - p.z};
    for (std::size_t s = 0; s < distance.size(); ++s)
      if (const DomainSide& side = scene.domain.sides[s];
          side.electrode && distance[s] - conductor.radius <= slack && !is_joined(side))
        refuse_it(i, fmt::format("the {} side of the domain, an electrode", side_names[s]));
  }
}

}  // namespace lichtenberg
