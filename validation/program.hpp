#pragma once

#include <map>
#include <string>

namespace lichtenberg::validation {

using Validate = int (*)(int argc, char** argv);

/// Returns the programs of this folder by name. Each receives its own arguments only and returns its exit status.
inline std::map<std::string, Validate>& programs() {
  static std::map<std::string, Validate> all;
  return all;
}

/// Registers a program.
struct Program {
  Program(const std::string& name, Validate validate) { programs().emplace(name, validate); }
};

}  // namespace lichtenberg::validation
