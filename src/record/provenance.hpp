#pragma once

#include <string>

#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// User, machine, command line and start of a run, as recorded in its result. lichtenberg_version() describes the
/// program.
struct Provenance {
  std::string user;
  std::string command_line;
  std::string petsc_options;  ///< options of the environment; those of the command line are in `command_line`
  std::string started;        ///< date and time in UTC, ISO 8601
  std::string machine;        ///< host, operating system and its release
  std::string processor;      ///< "unknown" if the system does not report it
  int cores = 0;
};

/// Returns the provenance of the running process; `started` is the time of this call.
Provenance provenance();

/// Returns the path of the group of a result that describes a session: 0 is the start of the run, k its k-th
/// resumption.
std::string session_group(int session);
/// Returns the number of sessions in a result: 1 plus the number of resumptions.
int sessions(const hdf5::Handle& file);
/// Writes the provenance, the program's version and, if the scene has a field, the field options of session number
/// `session` to a result.
void put_session(const hdf5::Handle& file, int session, const Provenance& provenance, const Scene& scene);
/// Returns a warning if a program of another version or commit wrote the last session of the result at `path`; empty
/// otherwise.
std::string warning_of_another_build(const hdf5::Handle& file, const std::string& path);

}  // namespace lichtenberg
