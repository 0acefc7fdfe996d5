#include "src/record/vtkhdf.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// Creates the group of an image whose first point is at `origin`, in units of the spacing.
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

/// Writes numbers of a grid's connectivity, `a_row` for each row of cells; chunks of several rows compress well.
void put_topology(const hdf5::Handle& group, const std::string& name, const std::vector<std::int64_t>& numbers,
                  std::size_t a_row, hid_t type) {
  constexpr std::size_t rows = 64;
  const hdf5::Shape shape{numbers.size()}, chunk{std::min(numbers.size(), rows * a_row)};
  hdf5::put_compressed<std::int64_t>(group, name, numbers, shape, {chunk, type}, "1");
}

/// Writes the corners of square cells, in rows from the origin. Each coordinate is compressed separately.
void put_corners(const hdf5::Handle& group, int nx, int ny, double h) {
  std::vector<double> corners;
  corners.reserve(std::size_t{3} * (nx + 1) * (ny + 1));
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) corners.insert(corners.end(), {i * h, j * h, 0});
  const hsize_t count = corners.size() / 3, rows = 64;
  hdf5::put_compressed<double>(group, "Points", corners, {count, 3},
                               {{std::min(count, rows * (nx + 1)), 1}, H5T_IEEE_F64LE}, "m");
}

/// Writes the cells explicitly, as VTKHDF requires for an unstructured grid.
void put_grid(const hdf5::Handle& group, int nx, int ny, double h) {
  constexpr int pixel = 8, corners = 4;  // VTK's type of a rectangle along the axes
  const auto across = static_cast<std::size_t>(nx), count = across * ny;
  std::vector<std::int64_t> connectivity, offsets{0};
  for (std::int64_t j = 0; j < ny; ++j)
    for (std::int64_t i = 0; i < nx; ++i) {
      const std::int64_t first = j * (nx + 1) + i, above = first + nx + 1;
      connectivity.insert(connectivity.end(), {first, first + 1, above, above + 1});
      offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    }
  put_corners(group, nx, ny, h);
  put_topology(group, "Connectivity", connectivity, corners * across, H5T_STD_I64LE);
  put_topology(group, "Offsets", offsets, across, H5T_STD_I64LE);
  put_topology(group, "Types", std::vector<std::int64_t>(count, pixel), across, H5T_STD_U8LE);
  const auto put_number = [&](const char* name, std::size_t number) {
    hdf5::put<std::int64_t>(group, name, std::array{static_cast<std::int64_t>(number)}, {1}, "1");
  };
  put_number("NumberOfPoints", (across + 1) * (ny + 1));
  put_number("NumberOfCells", count);
  put_number("NumberOfConnectivityIds", connectivity.size());
}

}  // namespace

void put_vtkhdf_grid(const hdf5::Handle& file, const laplace::Field& field) {
  const std::vector<std::int64_t> cells{field.nx, field.ny};
  if (hdf5::exists(file, "VTKHDF/cells")) {
    if (hdf5::get<std::int64_t>(file, "VTKHDF/cells") == cells) return;
    hdf5::check(H5Ldelete(file, "VTKHDF", H5P_DEFAULT));
  }
  const hdf5::Handle group = hdf5::open_group(file, "VTKHDF");
  put_array_attribute<std::int64_t, 2>(group, "Version", {1, 0});
  hdf5::put_fixed_attribute(group, "Type", "UnstructuredGrid");
  hdf5::put<std::int64_t>(group, "cells", cells, {2}, "1");
  hdf5::put(group, "cell_edge", field.h, "m");
  put_grid(group, field.nx, field.ny, field.h);
}

void put_vtkhdf(const hdf5::Handle& file, const laplace::Field& field, StoredField stored) {
  put_vtkhdf_grid(file, field);
  const hdf5::Handle data = hdf5::open_group(file, "VTKHDF/CellData");
  hdf5::put_fixed_attribute(data, "Scalars", "potential");
  const hdf5::Shape shape{field.value.size()}, row{static_cast<hsize_t>(field.nx)};
  const hid_t real = stored == StoredField::single_precision ? H5T_IEEE_F32LE : H5T_IEEE_F64LE;
  hdf5::put_compressed<double>(data, "potential", field.value, shape, {row, real}, "V");
  hdf5::put_compressed<std::int32_t>(data, "body", field.body, shape, {row, H5T_STD_I32LE}, "1");
}

void write_field_vtkhdf(const std::string& path, const laplace::Field& field, bool overwrite) {
  check_writable(path);
  if (!overwrite && std::filesystem::exists(path))
    throw InputError(fmt::format("the file {} exists: remove it or give the field another file", path));
  write_whole(path, [&](const hdf5::Handle& file) { put_vtkhdf(file, field); });
}

void write_lattice_vtkhdf(const std::string& path, const Lattice& lattice) {
  write_whole(path, [&](const hdf5::Handle& file) { put_lattice(file, lattice); });
}

}  // namespace lichtenberg
