#include "src/record/vtkhdf.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <functional>

#include "solvers/error.hpp"
#include "src/record/atomic_file.hpp"

namespace lichtenberg {
namespace {

template <class Number, std::size_t n>
void put_array_attribute(hid_t group, const std::string& name, const std::array<Number, n>& numbers) {
  hdf5::put_attribute(group, name, std::span<const Number>(numbers), {n});
}

template <class Number>
std::vector<Number> two_layers(const std::vector<Number>& layer) {
  std::vector<Number> layers = layer;
  layers.insert(layers.end(), layer.begin(), layer.end());
  return layers;
}

/// The group of an image whose first point is at `origin` spacings.
hdf5::Handle put_image(const hdf5::Handle& file, const std::array<int, 3>& points, double spacing,
                       const std::array<double, 3>& origin) {
  hdf5::Handle group = hdf5::open_group(file, "VTKHDF");
  put_array_attribute<std::int64_t, 2>(group, "Version", {1, 0});
  hdf5::put_fixed_attribute(group, "Type", "ImageData");
  put_array_attribute<std::int64_t, 6>(group, "WholeExtent", {0, points[0] - 1, 0, points[1] - 1, 0, points[2] - 1});
  put_array_attribute<double, 3>(group, "Origin", {origin[0] * spacing, origin[1] * spacing, origin[2] * spacing});
  put_array_attribute<double, 3>(group, "Spacing", {spacing, spacing, spacing});
  put_array_attribute<double, 9>(group, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1});
  return group;
}

void put_lattice(const hdf5::Handle& file, const Lattice& lattice) {
  const bool flat = lattice.points[2] == 1;
  const auto [nx, ny, nz] = lattice.points;
  const hdf5::Handle group = put_image(file, {nx, ny, flat ? 2 : nz}, lattice.spacing, {0.5, 0.5, flat ? -0.5 : 0.5});
  const hdf5::Handle points = hdf5::open_group(group, "PointData");
  hdf5::put_fixed_attribute(points, "Scalars", lattice.values.front().name);
  for (const Lattice::Values& values : lattice.values) {
    hdf5::Shape shape{static_cast<hsize_t>(flat ? 2 : nz), static_cast<hsize_t>(ny), static_cast<hsize_t>(nx)};
    if (values.components > 1) shape.push_back(values.components);
    hdf5::put<double>(points, values.name, flat ? two_layers(values.value) : values.value, shape, values.unit);
  }
}

void write_whole(const std::string& path, const std::function<void(const hdf5::Handle&)>& put) {
  try {
    const hdf5::Handle file = hdf5::create_in_memory();
    put(file);
    write_atomically(path, hdf5::image(file));
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} cannot be written ({})", path, error.what()));
  }
}

}  // namespace

void put_vtkhdf(const hdf5::Handle& file, const laplace::Field& field, StoredField stored) {
  const hdf5::Handle group = put_image(file, {field.nx, field.ny, 2}, field.h, {0.5, 0.5, -0.5});
  const hdf5::Handle points = hdf5::open_group(group, "PointData");
  hdf5::put_fixed_attribute(points, "Scalars", "potential");
  const hdf5::Shape shape{2, static_cast<hsize_t>(field.ny), static_cast<hsize_t>(field.nx)};
  // A row of both layers: what deflate has seen in the first it finds again in the second.
  const hdf5::Shape chunk{2, 1, shape[2]};
  const hid_t real = stored == StoredField::single_precision ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  hdf5::put_compressed<double>(points, "potential", two_layers(field.value), shape, chunk, real, "V");
  hdf5::put_compressed<std::int32_t>(points, "body", two_layers(field.body), shape, chunk, H5T_STD_I32LE, "1");
}

void write_field_vtkhdf(const std::string& path, const laplace::Field& field, bool overwrite) {
  check_writable(path);
  if (!overwrite && std::filesystem::exists(path))
    throw InputError(fmt::format("{} exists: remove it or give the field another file", path));
  write_whole(path, [&](const hdf5::Handle& file) { put_vtkhdf(file, field); });
}

void write_lattice_vtkhdf(const std::string& path, const Lattice& lattice) {
  write_whole(path, [&](const hdf5::Handle& file) { put_lattice(file, lattice); });
}

}  // namespace lichtenberg
