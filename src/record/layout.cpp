#include "src/record/layout.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <variant>

#include "src/effects/contact_discharge.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

constexpr const char* conductors = "/particles/conductors";
constexpr const char* step = "/particles/conductors/position/step";
constexpr const char* time = "/particles/conductors/position/time";
constexpr const char* all_contacts = "contacts_of_all_frames";  // [C][2]
constexpr const char* ends_of_contacts = "contacts_end";        // [T]
constexpr hsize_t dimension = 3;  // spheres whose centres lie in the plane z = 0; MDAnalysis reads nothing else

/// The instant first: the other elements link to it.
void append_instant(const hdf5::Handle& file, const Frame& frame) {
  const hdf5::Handle position = hdf5::open_group(file, std::string(conductors) + "/position");
  const bool first = !hdf5::exists(position, "step");
  const auto frames = first ? std::int64_t{0} : static_cast<std::int64_t>(hdf5::shape(position, "step")[0]);
  hdf5::append(position, "step", frames, "");
  hdf5::append(position, "time", frame.time, frame.time_unit);
}

/// Appends to a time-dependent element of H5MD. All elements share the step and time of the positions.
void append_element(const hdf5::Handle& file, const std::string& parent, const Column& column) {
  const std::string path = parent + "/" + column.name;
  const bool first = !hdf5::exists(file, path);
  const hdf5::Handle element = hdf5::open_group(file, path);
  hdf5::Shape shape;
  if (column.of == Column::Of::particles) shape.push_back(column.rows());
  if (column.width > 0) shape.push_back(column.width);
  std::visit(
      [&]<class Number>(const std::vector<Number>& values) {
        hdf5::append<Number>(element, "value", values, shape, column.unit);
      },
      column.values);
  if (!first) return;
  if (!exists(element, "step"))
    for (const auto& [from, to] : {std::pair{step, "step"}, std::pair{time, "time"}})
      hdf5::check(H5Lcreate_hard(file, from, element, to, H5P_DEFAULT, H5P_DEFAULT));
  if (!column.labels.empty()) hdf5::put_attribute(element, "terminals", column.labels);
}

/// Frames have different numbers of rows: all of them one after the other, where each frame's end, and those of the
/// last frame.
void append_list(const hdf5::Handle& file, const Column& column) {
  const hdf5::Handle group = hdf5::open_group(file, "network");
  const std::string all = column.name + "_of_all_frames";
  const hdf5::Shape row{column.width};
  std::visit(
      [&]<class Number>(const std::vector<Number>& values) {
        hdf5::append_rows<Number>(group, all, values, row, column.unit);
        hdf5::put<Number>(group, column.name, values, {column.rows(), column.width}, column.unit);
      },
      column.values);
  hdf5::append(group, column.name + "_end", static_cast<std::int64_t>(hdf5::shape(group, all)[0]), "1");
}

/// Numbers of one conductor's kind: VMD gives all conductors of a species one radius.
std::vector<double> distinct_radii(const Scene& scene) {
  std::set<double> radii;
  for (const Conductor& conductor : scene.conductors) radii.insert(conductor.radius);
  return {radii.begin(), radii.end()};
}

void put_point(hid_t group, const std::string& name, Vec2 point) {
  hdf5::put<double>(group, name, std::array{point.x, point.y}, {2}, "m");
}

void put_shape(hid_t group, const Disk& disk) {
  hdf5::put_attribute(group, "shape", "disk");
  put_point(group, "centre", disk.centre);
  hdf5::put(group, "radius", disk.radius, "m");
}

void put_shape(hid_t group, const Bar& bar) {
  hdf5::put_attribute(group, "shape", "bar");
  put_point(group, "from", bar.from);
  put_point(group, "to", bar.to);
  hdf5::put(group, "width", bar.width, "m");
}

void put_shape(hid_t group, const Ring& ring) {
  hdf5::put_attribute(group, "shape", "ring");
  put_point(group, "centre", ring.centre);
  hdf5::put(group, "radius", ring.radius, "m");
}

void put_electrodes(hid_t scene_group, const Scene& scene) {
  const hdf5::Handle electrodes = hdf5::open_group(scene_group, "electrodes");
  for (size_t k = 0; k < scene.electrodes.size(); ++k) {
    const hdf5::Handle group = hdf5::open_group(electrodes, std::to_string(k));
    hdf5::put_attribute(group, "name", scene.electrodes[k].name);
    hdf5::put(group, "potential", scene.electrodes[k].potential, "V");
    if (scene.electrodes[k].series_resistance > 0)
      hdf5::put(group, "series_resistance", scene.electrodes[k].series_resistance, "ohm");
    std::visit([&](const auto& shape) { put_shape(group, shape); }, scene.electrodes[k].shape);
  }
}

/// Walls of a packing, in the order in which contacts count them.
void put_walls(hid_t scene_group, const Scene& scene) {
  const hdf5::Handle group = hdf5::open_group(scene_group, "walls");
  std::vector<std::string> names;
  std::vector<double> point, normal;
  for (const Wall& wall : scene.walls) {
    names.push_back(wall.name);
    point.insert(point.end(), wall.point.begin(), wall.point.end());
    normal.insert(normal.end(), wall.normal.begin(), wall.normal.end());
  }
  hdf5::put_attribute(group, "names", names);
  hdf5::put<double>(group, "point", point, {names.size(), dimension}, "m");
  hdf5::put<double>(group, "normal", normal, {names.size(), dimension}, "1");
}

void put_domain(hid_t scene_group, const Domain& domain) {
  const hdf5::Handle group = hdf5::open_group(scene_group, "domain");
  if (domain.height > 0) hdf5::put(group, "height", domain.height, "m");
  put_point(group, "size", domain.size);
  std::vector<std::int32_t> electrode;
  std::vector<double> potential;
  for (const DomainSide& side : domain.sides) {
    electrode.push_back(side.electrode);
    potential.push_back(side.potential);
  }
  hdf5::put_attribute(group, "sides", std::vector<std::string>{"left", "right", "bottom", "top"});
  hdf5::put<std::int32_t>(group, "side_is_electrode", electrode, {electrode.size()}, "1");
  hdf5::put<double>(group, "side_potential", potential, {potential.size()}, "V");
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

void put_header(const hdf5::Handle& file, const Provenance& provenance) {
  hdf5::put_attribute(file, "lichtenberg_result", result_format);
  const hdf5::Handle h5md = hdf5::open_group(file, "h5md");
  hdf5::put_attribute<std::int32_t>(h5md, "version", std::array{1, 1}, {2});
  hdf5::put_attribute(hdf5::open_group(h5md, "author"), "name", provenance.user);
  const hdf5::Handle creator = hdf5::open_group(h5md, "creator");
  hdf5::put_attribute(creator, "name", "lichtenberg");
  hdf5::put_attribute(creator, "version", lichtenberg_version().number);
  const hdf5::Handle units = hdf5::open_group(h5md, "modules/units");
  hdf5::put_attribute<std::int32_t>(units, "version", std::array{1, 0}, {2});
  hdf5::put_attribute(units, "system", "SI");
}

void put_scene(const hdf5::Handle& file, const Scene& scene) {
  const hdf5::Handle group = hdf5::open_group(file, "scene");
  hdf5::put_attribute(group, "title", scene.title);
  hdf5::put_attribute(group, "path", scene.path);
  hdf5::put_text(group, "text", scene.text);
  hdf5::put(group, "seed", scene.seed, "1");
  hdf5::put(group, "permittivity", scene.medium.permittivity, "F m-1");
  hdf5::put(group, "viscosity", scene.medium.viscosity, "Pa s");
  hdf5::put(group, "depth", scene.medium.depth, "m");
  if (const auto* discharge = scene.effects.find<effects::ContactDischargeOptions>())
    hdf5::put(group, "contact_gap", discharge->gap, "m");
  put_domain(group, scene.domain);
  put_electrodes(group, scene);
  if (!scene.walls.empty()) put_walls(group, scene);
}

void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass) {
  const hdf5::Handle group = hdf5::open_group(file, conductors);
  const hdf5::Handle box = hdf5::open_group(group, "box");
  hdf5::put_attribute<std::int32_t>(box, "dimension", dimension);
  hdf5::put_attribute(box, "boundary", std::vector<std::string>(dimension, "none"));

  const std::vector<double> radii = distinct_radii(scene);
  std::vector<double> radius;
  std::vector<std::int32_t> species;
  for (const Conductor& conductor : scene.conductors) {
    radius.push_back(conductor.radius);
    const auto kind = std::lower_bound(radii.begin(), radii.end(), conductor.radius);
    species.push_back(static_cast<std::int32_t>(kind - radii.begin()));
  }
  hdf5::put<double>(group, "radius", radius, {radius.size()}, "m");
  hdf5::put<double>(group, "mass", mass, {mass.size()}, "kg");
  hdf5::put<std::int32_t>(group, "species", species, {species.size()}, "1");

  std::vector<std::int32_t> indices(radii.size());
  for (size_t k = 0; k < indices.size(); ++k) indices[k] = static_cast<std::int32_t>(k);
  const hdf5::Handle vmd = hdf5::open_group(file, "parameters/vmd_structure");
  hdf5::put<std::int32_t>(vmd, "indexOfSpecies", indices, {indices.size()}, "1");
  hdf5::put<double>(vmd, "radius", radii, {radii.size()}, "m");
}

void append_frame(const hdf5::Handle& file, const Frame& frame) {
  append_instant(file, frame);
  for (const Column& column : frame.columns) {
    if (column.of == Column::Of::particles) append_element(file, conductors, column);
    if (column.of == Column::Of::system) append_element(file, "/observables", column);
    if (column.of == Column::Of::list) append_list(file, column);
  }
}

std::vector<std::int64_t> contact_ends(const hdf5::Handle& file) {
  const std::string name = std::string("network/") + ends_of_contacts;
  return hdf5::exists(file, name) ? hdf5::get<std::int64_t>(file, name) : std::vector<std::int64_t>{};
}

std::vector<analysis::Contact> contacts_between(const hdf5::Handle& file, std::int64_t first, std::int64_t end) {
  if (first < 0 || end < first) throw hdf5::Error("the contacts of a frame end before they begin");
  const std::vector<std::int32_t> ends =
      hdf5::get_rows<std::int32_t>(file, std::string("network/") + all_contacts, first, end - first);
  std::vector<analysis::Contact> contacts;
  for (std::size_t k = 0; k + 1 < ends.size(); k += 2) contacts.emplace_back(ends[k], ends[k + 1]);
  return contacts;
}

void append_history(const hdf5::Handle& file, const ColumnGroup& history) {
  const hdf5::Handle group = hdf5::open_group(file, history.name);
  for (const Column& column : history.columns)
    std::visit(
        [&]<class Number>(const std::vector<Number>& values) {
          for (const Number value : values) hdf5::append(group, column.name, value, column.unit);
        },
        column.values);
}

void put_group(const hdf5::Handle& file, const ColumnGroup& columns) {
  const hdf5::Handle group = hdf5::open_group(file, columns.name);
  for (const Column& column : columns.columns) {
    hdf5::Shape shape{column.rows()};
    if (column.width > 0) shape.push_back(column.width);
    std::visit(
        [&]<class Number>(const std::vector<Number>& values) {
          hdf5::put<Number>(group, column.name, values, shape, column.unit);
        },
        column.values);
  }
}

void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint) {
  const hdf5::Handle group = hdf5::open_group(file, "checkpoint");
  put_arrays(group, "reals", checkpoint.reals);
  put_arrays(group, "integers", checkpoint.integers);
}

Checkpoint get_checkpoint(const hdf5::Handle& file) {
  return {get_arrays<double>(file, "checkpoint/reals"), get_arrays<std::int64_t>(file, "checkpoint/integers")};
}

std::vector<double> frame_times(const hdf5::Handle& file) {
  std::vector<double> times = hdf5::get<double>(file, time);
  if (times.empty()) throw hdf5::Error("no frames");
  return times;
}

}  // namespace lichtenberg
