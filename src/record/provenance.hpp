#pragma once

#include <string>

#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"

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

/// Group of a result for the start of the run (session 0) or one of the times it was resumed.
std::string session_group(int session);
/// Number of sessions in a result.
int sessions(const hdf5::Handle& file);
/// Writes where this session runs and how it solves the field.
void put_session(const hdf5::Handle& file, int session, const Provenance& provenance, const Scene& scene);
/// Tells that another build of the program wrote the last session of the result at `path`; empty if this one did.
std::string warning_of_another_build(const hdf5::Handle& file, const std::string& path);

}  // namespace lichtenberg
