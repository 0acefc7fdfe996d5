#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lichtenberg {

class ResultFile;

/// Executes the rest of a command that reads result files in a child process, because HDF5 may crash on damaged or
/// malicious bytes with a valid checksum. Returns in the child. The parent passes signals on, waits, and ends with the
/// child's status. If the child crashes, a second child reads each file as a whole. A file that crashes this child too
/// is damaged (exit status 2); otherwise the message reports an error of the program (exit status 1). Under mpirun,
/// whose processes must not fork, it has no effect.
void read_in_child(const std::vector<std::string>& files);

/// Calls `read` first in a child process, whose exceptions and results are discarded. For commands that use the data
/// afterwards. Throws InputError if the child crashes.
void try_reading(const std::string& file, const std::function<void()>& read);

/// Throws InputError if the result is damaged. `done`: participle for the message ("... cannot be `done`"). Prints a
/// message if another program has changed the file.
void check_bytes(const std::string& path, const std::string& done);

/// Prints a message on standard error if the file lost its checksum because another program changed it.
void warn_if_changed(const ResultFile& result);

}  // namespace lichtenberg
