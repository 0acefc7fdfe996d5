#include "src/record/layout.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <variant>

#include "solvers/geometry/closed_curve.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/gravity.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

constexpr const char* conductor_group = "/particles/conductors";
// Vectors in files have three components, with z = 0 in plane scenes, because MDAnalysis requires it
constexpr hsize_t dimension = 3;

/// Returns the radii of the conductors' species: VMD gives all conductors of a species one radius.
std::vector<double> distinct_radii(const Scene& scene) {
  std::set<double> radii;
  for (const Conductor& conductor : scene.conductors) radii.insert(conductor.radius);
  return {radii.begin(), radii.end()};
}

void put_disk(hid_t group, const char* shape, const std::vector<double>& centre, double radius) {
  hdf5::put_attribute(group, "shape", shape);
  hdf5::put<double>(group, "centre", centre, {centre.size()}, "m");
  hdf5::put(group, "radius", radius, "m");
}

void put_shape(hid_t group, const Disk& disk) { put_disk(group, "disk", {disk.centre.x, disk.centre.y}, disk.radius); }

void put_shape(hid_t group, const Ring& ring) { put_disk(group, "ring", {ring.centre.x, ring.centre.y}, ring.radius); }

void put_shape(hid_t group, const Bar& bar) {
  hdf5::put_attribute(group, "shape", "bar");
  hdf5::put<double>(group, "from", std::array{bar.from.x, bar.from.y}, {2}, "m");
  hdf5::put<double>(group, "to", std::array{bar.to.x, bar.to.y}, {2}, "m");
  hdf5::put(group, "width", bar.width, "m");
}

/// Writes the points of a polygon that deviates from the curve by 1e-4 of its size.
void put_shape(hid_t group, const Freeform& freeform) {
  const ClosedCurve& curve = *freeform.curve;
  const Vec2 size = curve.high() - curve.low();
  std::vector<double> points;
  for (const Vec2 p : curve.polygon(1e-4 * std::max(size.x, size.y))) points.insert(points.end(), {p.x, p.y});
  hdf5::put_attribute(group, "shape", curve.hollow() ? "hollow polygon" : "polygon");
  hdf5::put<double>(group, "points", points, {points.size() / 2, 2}, "m");
}

void put_sphere(hid_t group, const Electrode& electrode) {
  const Vec3 centre = electrode.centre();
  put_disk(group, "sphere", {centre.x, centre.y, centre.z}, std::get<Disk>(electrode.shape).radius);
}

void put_electrodes(hid_t scene_group, const Scene& scene) {
  const hdf5::Handle electrodes = hdf5::open_group(scene_group, "electrodes");
  for (size_t k = 0; k < scene.electrodes.size(); ++k) {
    const hdf5::Handle group = hdf5::open_group(electrodes, std::to_string(k));
    hdf5::put_attribute(group, "name", scene.electrodes[k].name);
    hdf5::put(group, "potential", scene.electrodes[k].potential.value, "V");
    if (scene.electrodes[k].series_resistance > 0)
      hdf5::put(group, "series_resistance", scene.electrodes[k].series_resistance, "ohm");
    if (scene.dimension() == 3)
      put_sphere(group, scene.electrodes[k]);
    else
      std::visit([&](const auto& shape) { put_shape(group, shape); }, scene.electrodes[k].shape);
  }
}

/// Writes the walls of a packing, in the order of their indices in contacts.
void put_walls(hid_t scene_group, const Scene& scene) {
  const hdf5::Handle group = hdf5::open_group(scene_group, "walls");
  std::vector<std::string> names;
  std::vector<double> point, normal;
  for (const Wall& wall : scene.walls) {
    names.push_back(wall.name);
    point.insert(point.end(), {wall.point.x, wall.point.y, wall.point.z});
    normal.insert(normal.end(), {wall.normal.x, wall.normal.y, wall.normal.z});
  }
  hdf5::put_attribute(group, "names", names);
  hdf5::put<double>(group, "point", point, {names.size(), dimension}, "m");
  hdf5::put<double>(group, "normal", normal, {names.size(), dimension}, "1");
}

void put_domain(hid_t scene_group, const Scene& scene) {
  const Domain& domain = scene.domain;
  const std::string unit = scene.units().length;
  const hdf5::Handle group = hdf5::open_group(scene_group, "domain");
  if (domain.dimension() == 3) hdf5::put(group, "height", domain.size.z, unit);  // read by older versions
  const std::array size{domain.size.x, domain.size.y, domain.size.z};
  const auto axes = static_cast<std::size_t>(domain.dimension());
  hdf5::put<double>(group, "size", std::span(size).first(axes), {axes}, unit);
  std::vector<std::int32_t> electrode;
  std::vector<double> potential;
  std::vector<std::string> names;
  for (int s = 0; s < 2 * domain.dimension(); ++s) {
    names.emplace_back(side_names[s]);
    electrode.push_back(domain.sides[s].electrode);
    potential.push_back(domain.sides[s].potential.value);
  }
  hdf5::put_attribute(group, "sides", names);
  hdf5::put<std::int32_t>(group, "side_is_electrode", electrode, {electrode.size()}, "1");
  hdf5::put<double>(group, "side_potential", potential, {potential.size()}, "V");
}

/// Writes the SI values of the units of a scene of grains.
void put_reference(const hdf5::Handle& file, const Reference& reference) {
  const hdf5::Handle group = hdf5::open_group(file, "reference");
  const auto [length, mass, velocity, charge] = reference;
  hdf5::put(group, "d0", length, "m");
  hdf5::put(group, "m0", mass, "kg");
  hdf5::put(group, "v0", velocity, "m s-1");
  hdf5::put(group, "q0", charge, "C");
  hdf5::put(group, "t0", length / velocity, "s");
}

/// Writes the box as H5MD describes it; its `edges` are stored with the frames (series.hpp).
void put_box(hid_t conductors_group, const Scene& scene) {
  const Box<3> box = scene.domain.box();
  const hdf5::Handle group = hdf5::open_group(conductors_group, "box");
  hdf5::put_attribute<std::int32_t>(group, "dimension", dimension);
  std::vector<std::string> boundary;
  for (int k = 0; k < 3; ++k) boundary.push_back(box.periodic(k) ? "periodic" : "none");
  hdf5::put_attribute(group, "boundary", boundary);
}

template <class Number>
void put_arrays(hid_t checkpoint, const std::string& kind, const std::map<std::string, std::vector<Number>>& arrays) {
  const hdf5::Handle group = hdf5::open_group(checkpoint, kind);
  for (const std::string& name : hdf5::names(group))
    if (!arrays.contains(name)) hdf5::check(H5Ldelete(group, name.c_str(), H5P_DEFAULT));
  for (const auto& [name, numbers] : arrays) hdf5::put<Number>(group, name, numbers, {numbers.size()}, "");
}

template <class Number>
std::map<std::string, std::vector<Number>> get_arrays(hid_t file, const std::string& path) {
  const hdf5::Handle group(H5Gopen2(file, path.c_str(), H5P_DEFAULT));
  std::map<std::string, std::vector<Number>> arrays;
  for (const std::string& name : hdf5::names(group)) arrays[name] = hdf5::get<Number>(group, name);
  return arrays;
}

}  // namespace

void put_header(const hdf5::Handle& file, const Scene& scene, const Provenance& provenance) {
  hdf5::put_attribute(file, "lichtenberg_result", result_format);
  const hdf5::Handle h5md = hdf5::open_group(file, "h5md");
  hdf5::put_attribute<std::int32_t>(h5md, "version", std::array{1, 1}, {2});
  hdf5::put_attribute(hdf5::open_group(h5md, "author"), "name", provenance.user);
  const hdf5::Handle creator = hdf5::open_group(h5md, "creator");
  hdf5::put_attribute(creator, "name", "lichtenberg");
  hdf5::put_attribute(creator, "version", lichtenberg_version().number);
  const hdf5::Handle units = hdf5::open_group(h5md, "modules/units");
  hdf5::put_attribute<std::int32_t>(units, "version", std::array{1, 0}, {2});
  // H5MD requires a name of the system and defines symbols of units only for "SI".
  hdf5::put_attribute(units, "system", scene.reference ? "reduced" : "SI");
}

std::string added_effects(const Scene& scene) {
  std::vector<std::string> names;
  for (const Effects::Entry& entry : scene.effects)
    if (std::ranges::find(effects::all_kinds(), entry.kind) == effects::all_kinds().end())
      names.push_back(entry.kind->name);
  return fmt::format("{}", fmt::join(names, ", "));
}

void put_scene(const hdf5::Handle& file, const Scene& scene) {
  const hdf5::Handle group = hdf5::open_group(file, "scene");
  hdf5::put_attribute(group, "title", scene.title);
  hdf5::put_attribute(group, "path", scene.path);
  hdf5::put_text(group, "text", scene.text);
  if (const std::string added = added_effects(scene); !added.empty())
    hdf5::put_attribute(group, "added_effects", added);
  if (!scene.started_from.empty()) hdf5::put_attribute(group, "started_from", scene.started_from);
  hdf5::put(group, "seed", scene.seed, "1");
  put_domain(group, scene);
  if (const auto* gravity = scene.effects.find<effects::GravityOptions>()) {
    const Vec3 down = effects::down(*gravity, scene.domain);
    hdf5::put_attribute<double>(group, "down", std::array{down.x, down.y, down.z}, {3});
  }
  if (scene.reference) return put_reference(file, *scene.reference);
  hdf5::put(group, "permittivity", scene.medium.permittivity, "F m-1");
  hdf5::put(group, "viscosity", scene.medium.viscosity, "Pa s");
  hdf5::put(group, "depth", scene.medium.depth, "m");
  if (const auto gap = number_in(scene, &EffectKind::contact_gap)) hdf5::put(group, "contact_gap", *gap, "m");
  put_electrodes(group, scene);
  if (!scene.walls.empty()) put_walls(group, scene);
}

std::vector<double> box_edges(const Scene& scene) {
  const Box<3> box = scene.domain.box();
  if (!box.any_periodic()) return {};
  const double depth = box.lengths.z > 0 ? box.lengths.z : scene.medium.depth;
  return {box.lengths.x, 0, 0, 0, box.lengths.y, 0, 0, 0, depth};
}

void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass) {
  const hdf5::Handle group = hdf5::open_group(file, conductor_group);
  put_box(group, scene);
  const std::vector<double> radii = distinct_radii(scene);
  std::vector<double> radius;
  std::vector<std::int32_t> species;
  for (const Conductor& conductor : scene.conductors) {
    radius.push_back(conductor.radius);
    const auto kind = std::lower_bound(radii.begin(), radii.end(), conductor.radius);
    species.push_back(static_cast<std::int32_t>(kind - radii.begin()));
  }
  hdf5::put<double>(group, "radius", radius, {radius.size()}, scene.units().length);
  hdf5::put<double>(group, "mass", mass, {mass.size()}, scene.units().mass);
  hdf5::put<std::int32_t>(group, "species", species, {species.size()}, "1");

  std::vector<std::int32_t> indices(radii.size());
  for (size_t k = 0; k < indices.size(); ++k) indices[k] = static_cast<std::int32_t>(k);
  const hdf5::Handle vmd = hdf5::open_group(file, "parameters/vmd_structure");
  hdf5::put<std::int32_t>(vmd, "indexOfSpecies", indices, {indices.size()}, "1");
  hdf5::put<double>(vmd, "radius", radii, {radii.size()}, scene.units().length);
}

void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint) {
  const hdf5::Handle group = hdf5::open_group(file, "checkpoint");
  put_arrays(group, "reals", checkpoint.reals);
  put_arrays(group, "integers", checkpoint.integers);
}

Checkpoint get_checkpoint(const hdf5::Handle& file) {
  return {get_arrays<double>(file, "checkpoint/reals"), get_arrays<std::int64_t>(file, "checkpoint/integers")};
}

}  // namespace lichtenberg
