#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"

namespace lichtenberg {

/// Adds all datasets below a group except texts, by path.
inline void collect_numbers(hid_t group, const std::string& path,
                            std::map<std::string, std::vector<std::byte>>& bytes) {
  for (const std::string& name : hdf5::names(group)) {
    const hdf5::Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT));
    if (H5Iget_type(object) == H5I_GROUP) {
      collect_numbers(object, path + "/" + name, bytes);
    } else if (const hdf5::Handle type(H5Dget_type(object)); H5Tget_class(type) != H5T_STRING) {
      const hdf5::Handle space(H5Dget_space(object));
      std::vector<std::byte>& data = bytes[path + "/" + name];
      data.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)) * H5Tget_size(type));
      hdf5::check(H5Dread(object, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()));
    }
  }
}

/// All data of a result file except texts, by path.
inline std::map<std::string, std::vector<std::byte>> numbers_in(const std::string& file) {
  std::map<std::string, std::vector<std::byte>> bytes;
  collect_numbers(hdf5::load(file), "", bytes);
  return bytes;
}

}  // namespace lichtenberg
