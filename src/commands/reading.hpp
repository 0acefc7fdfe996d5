#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lichtenberg {

class ResultFile;

/// The rest of a command that reads result files, in a child process: HDF5 may crash on bytes that are damaged, or made
/// to harm, though their checksum is right. Returns in the child. This process passes signals on, waits, and ends as
/// the child does. If the child crashes, a second child reads each file as a whole: a file at which that one crashes
/// too is damaged (exit status 2), else the sentence names an error of the program (exit status 1). Under mpirun, whose
/// processes must not fork, it does nothing.
void read_in_child(const std::vector<std::string>& files);

/// For a command that goes on with the data read: calls `read` in a child process first, whose exceptions
/// and results are lost. Throws InputError if the child crashes.
void try_reading(const std::string& file, const std::function<void()>& read);

/// Throws InputError, with what was to be `done`, if the result is damaged; says so if another program has changed it.
void check_bytes(const std::string& path, const std::string& done);

/// Says on standard error that a file has lost its checksum to another program, if it has.
void warn_if_changed(const ResultFile& result);

}  // namespace lichtenberg
