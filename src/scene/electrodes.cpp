#include "src/scene/electrodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <type_traits>

#include <fmt/format.h>

#include "solvers/geometry/box.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/scene/circuits.hpp"
#include "src/scene/freeform.hpp"

namespace lichtenberg {
namespace {

std::array<Vec2, 4> corners(const Bar& bar) {
  const Vec2 axis = (bar.to - bar.from) / norm(bar.to - bar.from);
  const Vec2 half = 0.5 * bar.width * perpendicular(axis);
  return {bar.from - half, bar.from + half, bar.to + half, bar.to - half};
}

/// Returns the largest extent of the corners along a direction.
double reach(const std::array<Vec2, 4>& points, Vec2 direction) {
  double far = dot(points[0], direction);
  for (const Vec2 p : points) far = std::max(far, dot(p, direction));
  return far;
}

// Overloads that return true if two bodies touch.

bool touch(const Disk& disk, const Disk& other) { return gap(disk, other) <= 0; }
bool touch(const Disk& disk, const Bar& bar) { return gap(disk, bar) <= 0; }
bool touch(const Disk& disk, const Ring& ring) { return gap(disk, ring) <= 0; }
bool touch(const Ring&, const Ring&) { return true; }  // both extend to infinity
/// Tests the corners of the bar, because its point farthest from the ring's centre is a corner.
bool touch(const Bar& bar, const Ring& ring) {
  return std::ranges::any_of(corners(bar), [&](Vec2 corner) { return signed_distance(ring, corner) <= 0; });
}
/// Tests the axes of both rectangles: two convex bodies are disjoint if one of these axes separates them.
bool touch(const Bar& a, const Bar& b) {
  const auto corners_a = corners(a), corners_b = corners(b);
  for (const Vec2 axis : {a.to - a.from, b.to - b.from})
    for (const Vec2 direction : {axis, perpendicular(axis), -axis, -perpendicular(axis)})
      if (reach(corners_a, direction) < -reach(corners_b, -direction)) return false;
  return true;
}
bool touch(const auto& other,
           const Freeform& freeform) requires(!std::is_same_v<std::decay_t<decltype(other)>, Freeform>) {
  return touch(freeform, other);
}
bool touch(const Bar& bar, const Disk& disk) { return touch(disk, bar); }
bool touch(const Ring& ring, const Disk& disk) { return touch(disk, ring); }
bool touch(const Ring& ring, const Bar& bar) { return touch(bar, ring); }
bool touch(const Shape& a, const Shape& b) {
  return std::visit([](const auto& first, const auto& second) { return touch(first, second); }, a, b);
}

/// Returns a side of the domain as a bar of zero width.
Bar line_of(int side, Vec2 size) {
  const Vec2 corner[4] = {{0, 0}, {size.x, 0}, {size.x, size.y}, {0, size.y}};
  switch (side) {
    case 0:
      return {corner[0], corner[3]};
    case 1:
      return {corner[1], corner[2]};
    case 2:
      return {corner[0], corner[1]};
    default:
      return {corner[3], corner[2]};
  }
}

/// Returns the whole domain as a bar.
Bar box(Vec2 size) { return {{0, 0.5 * size.y}, {size.x, 0.5 * size.y}, size.y}; }

Shape build_shape(const ElectrodeDraft& electrode, Vec2 size) {
  if (electrode.shape == "disk") return Disk{electrode.centre, electrode.radius};
  if (electrode.shape == "ring") return Ring{electrode.centre, electrode.radius};
  if (electrode.shape == "bar") return Bar{electrode.from, electrode.to, electrode.width};
  if (electrode.side == "left") return Disk{{0, electrode.at}, electrode.radius};
  if (electrode.side == "right") return Disk{{size.x, electrode.at}, electrode.radius};
  if (electrode.side == "bottom") return Disk{{electrode.at, 0}, electrode.radius};
  return Disk{{electrode.at, size.y}, electrode.radius};
}

/// Returns the depth (m) to which a ring, or a disk centred outside the domain, extends into the domain; infinite for
/// other shapes.
double depth_in_domain(const Shape& shape, Vec2 size) {
  if (const Ring* ring = std::get_if<Ring>(&shape)) {
    const auto from_ring = [&](double x, double y) { return norm(Vec2{x, y} - ring->centre) - ring->radius; };
    return std::max({from_ring(0, 0), from_ring(size.x, 0), from_ring(0, size.y), from_ring(size.x, size.y)});
  }
  const Disk* disk = std::get_if<Disk>(&shape);
  if (disk == nullptr) return INFINITY;
  const Vec2 nearest{std::clamp(disk->centre.x, 0.0, size.x), std::clamp(disk->centre.y, 0.0, size.y)};
  return nearest == disk->centre ? INFINITY : disk->radius - norm(nearest - disk->centre);
}

/// Checks that the grid resolves an electrode. A grid represents an electrode by the cells whose centres lie in it, or
/// by the electrode's centre. Every point of the domain is within half a cell diagonal of a cell centre.
void check_depth(const Draft& draft, const ElectrodeDraft& electrode, const Shape& shape) {
  const Vec2 size = plane(draft.scene.domain.size);
  const double least = std::sqrt(0.5) * std::max(size.x, size.y) / draft.field.options.cells;
  const double depth = depth_in_domain(shape, size);
  if (depth < least)
    refuse(
        draft.scene.path, electrode.line,
        fmt::format("the {} reaches into the domain by {:.3g} m{}: it must be {:.3g} m at least, half the diagonal of "
                    "a cell of the field's grid",
                    electrode.shape, std::max(depth, 0.0), depth <= 0 ? ", which is not at all" : "", least));
}

void check_position(const Draft& draft, const ElectrodeDraft& electrode, const Shape& shape) {
  const Vec3 size = draft.scene.domain.size;
  const auto refuse_it = [&](const std::string& why) { refuse(draft.scene.path, electrode.line, why); };
  if (electrode.shape == "half-disk") {
    const double along = electrode.side == "left" || electrode.side == "right" ? size.y : size.x;
    if (electrode.at > along)
      refuse_it(fmt::format("electrode.at = {:g} m lies outside the domain: the {} side goes from 0 to {:g} m",
                            electrode.at, electrode.side, along));
  }
  const Bar* bar = std::get_if<Bar>(&shape);
  if (bar && bar->from == bar->to)
    refuse_it("electrode.from and electrode.to are the same point: a bar needs a length");
  const Ring* ring = std::get_if<Ring>(&shape);
  const Shape inside =
      ring ? Shape(Disk{ring->centre, ring->radius}) : shape;  // for a ring, its opening, which contains fluid
  if (!touch(inside, box(plane(size))))
    refuse_it(fmt::format("the {} lies outside the domain, which goes from [0, 0] to [{:g}, {:g}] m", electrode.shape,
                          size.x, size.y));
  check_depth(draft, electrode, shape);
}

/// Returns true if two electrodes or electrode sides have one potential at all times.
bool at_one_potential(const auto& one, const auto& other) {
  return one.circuit == other.circuit && (one.circuit >= 0 || one.potential == other.potential);
}

/// Returns true if a series resistor or a circuit of its own separates an electrode or a side from others.
bool in_circuit(const Electrode& electrode) { return electrode.circuit >= 0 || electrode.series_resistance > 0; }

/// Returns true if two electrodes or electrode sides are in the same circuit.
bool in_one_circuit(const auto& one, const auto& other) { return one.circuit >= 0 && one.circuit == other.circuit; }

/// Describes the potential of an electrode side.
std::string potential_of_side(const DomainSide& side) {
  return side.circuit >= 0 ? "in a circuit" : "at " + in_words(side.potential);
}

/// Checks corners of electrode sides. Between sides at different potentials, the field and the charge on both diverge
/// there.
void check_corners(const Draft& draft) {
  const std::array<DomainSide, 6>& sides = draft.scene.domain.sides;
  for (int across = 0; across < 6; ++across)
    for (int along = across / 2 * 2 + 2; along < 6; ++along)
      if (sides[across].electrode && sides[along].electrode && !at_one_potential(sides[across], sides[along]))
        refuse(draft.scene.path, draft.line("domain"),
               fmt::format("the {} side of the domain {} touches the {} side {} in {}: electrodes that touch must have "
                           "the same potential",
                           side_names[across], potential_of_side(sides[across]), side_names[along],
                           potential_of_side(sides[along]), draft.domain_size.count == 3 ? "an edge" : "a corner"));
}

/// A fixed sphere of an electrode in three dimensions.
struct FixedSphere {
  Vec3 centre;
  double radius = 0;
};

/// Returns the closed chain of spheres for a torus around the z axis (docs/numerics/spheres.md). A chain of touching
/// spheres has the capacitance of a torus whose wire has 0.8815 of their radius. With gaps, where the spheres have the
/// part f of the radius of touching ones, it is 0.8815 - 0.24 (1 - f).
std::vector<FixedSphere> spheres_of_torus(const ElectrodeDraft& torus) {
  constexpr double touching = 0.8815, by_gap = 0.24;
  const int count = static_cast<int>(std::numbers::pi / std::asin(torus.wire_radius / touching / torus.radius));
  const double half_distance = torus.radius * std::sin(std::numbers::pi / count);
  const double part = torus.wire_radius / touching / half_distance;
  const double radius = std::min(half_distance, torus.wire_radius / (touching - by_gap * (1 - part)));
  std::vector<FixedSphere> spheres;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * k / count;
    spheres.push_back(
        {torus.position.value + torus.radius * Vec3{std::cos(angle), std::sin(angle), 0}, radius * (1 - 1e-12)});
  }
  return spheres;
}

/// Checks the shape of an electrode, which the dimension of the domain must allow, and its keys in three dimensions.
void check_dimension_of(const Draft& draft, const ElectrodeDraft& written) {
  const auto refuse_it = [&](const std::string& message) { refuse(draft.scene.path, written.line, message); };
  const int dimension = draft.domain_size.count;
  const bool in_space = written.shape == "sphere" || written.shape == "torus";
  if (in_space != (dimension == 3))
    refuse_it(fmt::format("electrode.shape = \"{}\" is not allowed in {} dimensions: {}", written.shape,
                          dimension == 3 ? "three" : "two",
                          dimension == 3 ? "\"sphere\" and \"torus\" are, and sides of the domain can be electrodes"
                                         : "\"disk\", \"half-disk\", \"bar\", \"ring\", \"polygon\", "
                                           "\"ellipse\" and \"curve\" are"));
  if (dimension == 2) return;
  if (written.position.count != 3)
    refuse_it("electrode.position has 2 numbers, but the domain has 3: both must have the same number");
  if (written.shape == "sphere") return;
  if (written.wire_radius > written.radius / 8)
    refuse_it(
        fmt::format("electrode.wire_radius = {:g} is not allowed: it must be at most an eighth of the torus's "
                    "radius, {:g} m",
                    written.wire_radius, written.radius / 8));
  if (written.series_resistance || written.circuit >= 0)
    refuse_it(
        "an electrode with shape = \"torus\" consists of separate spheres: a series_resistance, a charge and a circuit "
        "are not allowed");
}

/// Checks a sphere of an electrode in three dimensions: its distance from the sides and from other electrodes.
void check_sphere(const Draft& draft, const ElectrodeDraft& written, const FixedSphere& sphere,
                  std::span<const Electrode> others) {
  const auto refuse_it = [&](const std::string& message) { refuse(draft.scene.path, written.line, message); };
  const Vec3 p = sphere.centre, size = draft.scene.domain.size;
  const Box<3> box = draft.scene.domain.box();
  for (int k = 0; k < 3; ++k)
    if (box.periodic(k) ? p[k] < 0 || p[k] > size[k] : p[k] <= sphere.radius || p[k] >= size[k] - sphere.radius)
      refuse_it(
          fmt::format("electrode.position = [{:g}, {:g}, {:g}] m is not allowed: this {} is on or through a "
                      "side of the domain, which goes to [{:g}, {:g}, {:g}] m",
                      written.position.value.x, written.position.value.y, written.position.value.z, written.shape,
                      size.x, size.y, size.z));
  for (const Electrode& other : others)
    if (norm(box.difference(p, other.centre())) <= sphere.radius + std::get<Disk>(other.shape).radius)
      refuse_it(fmt::format("this electrode touches the electrode \"{}\": fixed spheres must not touch", other.name));
}

/// Appends the spheres of an electrode in three dimensions.
void add_spheres(const Draft& draft, const ElectrodeDraft& written, const std::string& name,
                 std::vector<Electrode>& electrodes) {
  const bool torus = written.shape == "torus";
  const std::vector<FixedSphere> spheres =
      torus ? spheres_of_torus(written) : std::vector<FixedSphere>{{written.position.value, written.radius}};
  const std::size_t others = electrodes.size();
  for (const FixedSphere& sphere : spheres) {
    check_sphere(draft, written, sphere, std::span(electrodes).first(others));
    electrodes.push_back({torus ? fmt::format("{} {}", name, electrodes.size() - others + 1) : name,
                          Disk{plane(sphere.centre), sphere.radius}, written.potential.value_or(0),
                          written.series_resistance.value_or(0), sphere.centre.z, written.circuit});
  }
}

/// Makes an electrode of the plane, and checks its position.
Electrode make_plane_electrode(const Draft& draft, const ElectrodeDraft& written, const std::string& name) {
  const std::shared_ptr<const ClosedCurve> curve = is_freeform(written) ? make_freeform(draft, written, name) : nullptr;
  const Shape shape = curve ? Shape(Freeform{curve.get()}) : build_shape(written, plane(draft.scene.domain.size));
  if (!curve) check_position(draft, written, shape);
  return {name, shape, written.potential.value_or(0), written.series_resistance.value_or(0), 0, written.circuit, curve};
}

void check_short_circuits(const Draft& draft, const std::vector<Electrode>& electrodes) {
  check_corners(draft);
  const Domain& domain = draft.scene.domain;
  for (std::size_t i = 0; i < electrodes.size(); ++i) {
    const auto refuse_it = [&](const std::string& other, const Signal& potential) {
      refuse(
          draft.scene.path, draft.electrodes[i].line,
          fmt::format("the electrode \"{}\" at {} touches {} at {}: electrodes that touch must have the same potential",
                      electrodes[i].name, in_words(electrodes[i].potential), other, in_words(potential)));
    };
    const auto refuse_resistor = [&](const std::string& other) {
      refuse(
          draft.scene.path, draft.electrodes[i].line,
          fmt::format("the electrode \"{}\" touches {}, and one of them is behind a resistor or in a circuit: such an "
                      "electrode must not touch an electrode outside its circuit",
                      electrodes[i].name, other));
    };
    for (std::size_t j = 0; j < i; ++j)
      if ((in_circuit(electrodes[i]) || in_circuit(electrodes[j])) && !in_one_circuit(electrodes[i], electrodes[j]) &&
          touch(electrodes[i].shape, electrodes[j].shape))
        refuse_resistor(fmt::format("the electrode \"{}\"", electrodes[j].name));
    for (int side = 0; side < 4; ++side)
      if (const DomainSide& other = domain.sides[side];
          other.electrode && (in_circuit(electrodes[i]) || other.circuit >= 0) &&
          !in_one_circuit(electrodes[i], other) && touch(electrodes[i].shape, line_of(side, plane(domain.size))))
        refuse_resistor(fmt::format("the {} side of the domain", side_names[side]));
    for (std::size_t j = 0; j < i; ++j)
      if (!at_one_potential(electrodes[i], electrodes[j]) && touch(electrodes[i].shape, electrodes[j].shape))
        refuse_it(fmt::format("the electrode \"{}\"", electrodes[j].name), electrodes[j].potential);
    for (int side = 0; side < 4; ++side)
      if (domain.sides[side].electrode && !at_one_potential(domain.sides[side], electrodes[i]) &&
          touch(electrodes[i].shape, line_of(side, plane(domain.size))))
        refuse_it(fmt::format("the {} side of the domain", side_names[side]), domain.sides[side].potential);
  }
}

}  // namespace

std::vector<Electrode> build_electrodes(const Draft& draft) {
  std::vector<Electrode> electrodes;
  std::set<std::string> names;
  const std::vector<std::string> all_names = names_of_electrodes(draft);
  const bool in_space = draft.domain_size.count == 3;
  for (std::size_t e = 0; e < draft.electrodes.size(); ++e) {
    const ElectrodeDraft& written = draft.electrodes[e];
    check_dimension_of(draft, written);
    const std::size_t first = electrodes.size();
    if (in_space)
      add_spheres(draft, written, all_names[e], electrodes);
    else
      electrodes.push_back(make_plane_electrode(draft, written, all_names[e]));
    for (std::size_t k = first; k < electrodes.size(); ++k)
      if (!names.insert(electrodes[k].name).second)
        refuse(draft.scene.path, written.line,
               fmt::format("electrode.name = \"{}\" is taken: names must differ", electrodes[k].name));
  }
  draft.domain_size.count == 3 ? check_corners(draft) : check_short_circuits(draft, electrodes);
  return electrodes;
}

double gap(const Conductor& conductor, const Electrode& electrode, const Domain& domain) {
  if (domain.dimension() == 2) return gap(Disk{plane(conductor.position), conductor.radius}, electrode.shape);
  return norm(domain.box().difference(conductor.position, electrode.centre())) -
         std::get<Disk>(electrode.shape).radius - conductor.radius;
}

void check_disks_only(const Draft& draft, const std::vector<Electrode>& electrodes) {
  const Domain& domain = draft.scene.domain;
  for (std::size_t i = 0; i < electrodes.size(); ++i) {
    const auto refuse_it = [&](const std::string& why) {
      refuse(draft.scene.path, draft.electrodes[i].line,
             fmt::format("field.method = \"{}\" does not solve a scene where the electrode \"{}\" {}: whole disks, "
                         "and disks centred on a side, are allowed; other methods are {}",
                         draft.field.method->name, electrodes[i].name, why,
                         field_methods_that(2, [](const FieldMethodKind& method) { return !method.only_disks; })));
    };
    const Disk* disk = std::get_if<Disk>(&electrodes[i].shape);
    if (disk == nullptr)
      refuse_it((draft.electrodes[i].shape == "ellipse" ? "is an " : "is a ") + draft.electrodes[i].shape);
    const std::array distance = {disk->centre.x, domain.size.x - disk->centre.x, disk->centre.y,
                                 domain.size.y - disk->centre.y};
    const double rounding =
        1e-12 * std::max(domain.size.x, domain.size.y);  // rounding of a centre that is meant to be on a side
    int electrode_sides = 0;
    for (int side = 0; side < 4; ++side) {
      const bool on_side = std::abs(distance[side]) <= rounding;
      if (!on_side && distance[side] < disk->radius - rounding)
        refuse_it(fmt::format("is cut by the {} side off its centre", side_names[side]));
      electrode_sides += on_side && domain.sides[side].electrode;
    }
    if (electrode_sides > 1) refuse_it("is centred where two electrode sides meet");
    for (std::size_t j = 0; j < i; ++j)
      if (gap(*disk, electrodes[j].shape) < -rounding)
        refuse_it(fmt::format("overlaps the electrode \"{}\"", electrodes[j].name));
  }
}

}  // namespace lichtenberg
