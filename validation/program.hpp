#pragma once

#include <map>
#include <string>

namespace lichtenberg::validation {

/// Main function of a validation program.
using Validate = int (*)(int argc, char** argv);

/// Returns the validation programs of this folder by name. Each receives its own arguments only and returns its exit
/// status.
inline std::map<std::string, Validate>& programs() {
  static std::map<std::string, Validate> all;
  return all;
}

/// Registers a validation program in programs(), as a static object.
struct Program {
  Program(const std::string& name, Validate validate) { programs().emplace(name, validate); }
};

}  // namespace lichtenberg::validation
