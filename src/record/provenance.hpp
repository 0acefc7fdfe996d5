#pragma once

#include <string>

namespace lichtenberg {

/// Where and how this program runs; what it is, lichtenberg_version() says.
struct Provenance {
  std::string user;
  std::string command_line;
  std::string petsc_options;  ///< of the environment; those of the command line stand there
  std::string started;        ///< date and time in UTC, ISO 8601
  std::string machine;        ///< host, operating system and its release
  std::string processor;      ///< "unknown" where the system does not say
  int cores = 0;
};

/// Of the running process; `started` is the moment of this call.
Provenance provenance();

}  // namespace lichtenberg
