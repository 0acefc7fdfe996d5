#pragma once

#include <string>

namespace lichtenberg {

/// What the Python package of python/lichtenberg is asked for.
struct PackageRequest {
  std::string result, format, out, frames;
  bool overwrite = false;
};

/// Becomes the package's command of that name: its exit status is the program's. Throws InputError, with what was to be
/// `done`, if the result is damaged, which Python's HDF5 would crash on; Failure if Python cannot be started.
[[noreturn]] void become_package(const std::string& command, const std::string& done, const PackageRequest& request);

}  // namespace lichtenberg
