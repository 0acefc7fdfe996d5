#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "solvers/error.hpp"

namespace lichtenberg {

/// Temporary folder, which the destructor removes with its files.
class ScratchFolder {
 public:
  /// Creates the folder. Throws Failure if it cannot be created.
  ScratchFolder() : path_((std::filesystem::temp_directory_path() / "lichtenberg-XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) throw Failure("no folder for temporary files can be made at " + path_);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace lichtenberg
