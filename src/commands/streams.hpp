#pragma once

#include <string>
#include <string_view>

namespace lichtenberg {

/// Prepares standard input, output and error, once per process, before any file is opened.
///
/// Closed streams become /dev/null, so that no file receives their descriptor and the printed text with it. Failed
/// writes (full disk, closed pipe) neither throw nor end the program. Errors of standard error are ignored. Errors of
/// standard output are kept for output_error().
void prepare_streams();

/// Replaces control characters other than tabs by text such as \x1b or \x0a. Names in files from others can then not
/// control a terminal, and a message is one line.
std::string printable(std::string_view text);

/// Declares that the results are in files and printed output only repeats them. Output that cannot be written is then
/// no failure of the command.
void output_is_optional();
/// Returns true if output_is_optional() has been called: printed output then only repeats the contents of files.
bool is_output_optional();

/// Flushes standard output. Returns the errno of the first failed write since prepare_streams(); 0 if there was none.
int output_error();

/// Returns true if the reader of standard output has closed the pipe and the program should end by SIGPIPE. False if
/// the parent had SIGPIPE ignored, or if the output is optional.
bool closed_pipe_ends_program();
/// Ends the program by SIGPIPE.
void end_by_closed_pipe();

}  // namespace lichtenberg
