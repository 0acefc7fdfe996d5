#pragma once

#include <string>
#include <string_view>

namespace lichtenberg {

/// Prepares standard input, output and error, once in a process, before any file is opened:
/// - a stream that is closed becomes /dev/null, so that no file gets its descriptor and with it what is printed;
/// - a write to standard error or output that fails (a full disk, a closed pipe) throws nothing and ends nothing. That
///   of standard error is forgotten, that of standard output is kept for output_error().
void prepare_streams();

/// The text with control characters other than line ends and tabs written as \x1b, so that names of files and keys that
/// a stranger chose do nothing to a terminal.
std::string printable(std::string_view text);

/// Says that the command's work stands in files, and that what it prints repeats it: then output that cannot be written
/// is no failure of the command.
void output_is_optional();
bool is_output_optional();

/// Writes what standard output holds back. Returns the errno of the first write that failed since prepare_streams(), 0
/// if none did.
int output_error();

/// Whether standard output is a pipe that its reader has closed and the program ends by SIGPIPE, as the system has it:
/// not if its parent has it ignore that signal, or if the output is optional.
bool closed_pipe_ends_program();
void end_by_closed_pipe();

}  // namespace lichtenberg
