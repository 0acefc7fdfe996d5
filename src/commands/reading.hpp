#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lichtenberg {

class ResultFile;

/// Executes the rest of a command in a child process, because HDF5 may crash on damaged or malicious result files with
/// a valid checksum. Returns in the child. The parent passes signals on, waits, and ends with the child's status. If
/// the child crashes, further children read each of the `files` as a whole. A file that crashes such a child too is
/// damaged (exit status 2); otherwise the message reports an error of the program (exit status 1). The function has no
/// effect if the system allows no further process, and with several processes (mpirun), which must not fork.
void read_in_child(const std::vector<std::string>& files);

/// Calls `read` in a child process, whose exceptions and results are discarded, to test if reading `file` crashes. For
/// commands that use the data afterwards. Throws InputError if the child crashes. Has no effect where read_in_child()
/// has none.
void try_reading(const std::string& file, const std::function<void()>& read);

/// Throws InputError if the result file is damaged. `done`: participle for the message ("... cannot be `done`"). Prints
/// a message if another program has changed the file.
void check_bytes(const std::string& path, const std::string& done);

/// Prints a message on standard error if the result file lost its checksum because another program changed it.
void warn_if_changed(const ResultFile& result);

}  // namespace lichtenberg
