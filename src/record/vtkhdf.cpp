#include "src/record/vtkhdf.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>

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

}  // namespace

void put_vtkhdf(const hdf5::Handle& file, const laplace::Field& field, StoredField stored) {
  const hdf5::Handle group = hdf5::open_group(file, "VTKHDF");
  put_array_attribute<std::int64_t, 2>(group, "Version", {1, 0});
  hdf5::put_fixed_attribute(group, "Type", "ImageData");
  put_array_attribute<std::int64_t, 6>(group, "WholeExtent", {0, field.nx - 1, 0, field.ny - 1, 0, 1});
  put_array_attribute<double, 3>(group, "Origin", {0.5 * field.h, 0.5 * field.h, -0.5 * field.h});
  put_array_attribute<double, 3>(group, "Spacing", {field.h, field.h, field.h});
  put_array_attribute<double, 9>(group, "Direction", {1, 0, 0, 0, 1, 0, 0, 0, 1});
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
  try {
    const hdf5::Handle file = hdf5::create_in_memory();
    put_vtkhdf(file, field);
    write_atomically(path, hdf5::image(file));
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} cannot be written ({})", path, error.what()));
  }
}

}  // namespace lichtenberg
