#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// Meaning of the exit status, for the help and the manual page.
inline constexpr std::string_view exit_status_help =
    "Exit status: 0 for success, 1 for work that failed, 2 for input that cannot be used. After a signal\nthe shell "
    "reports 128 plus its number, as 130 for Ctrl-C.";

/// Returns all names of an argument of a command: its own, then alternative names that no other argument of the command
/// has.
std::vector<std::string> names_of(const Argument& argument, const Command& command);

/// Makes a bash script that completes commands, options, their allowed values and file names.
std::string bash_completion(const std::vector<Command>& commands);

/// Makes a manual page (roff) of all commands.
std::string manual_page(const std::vector<Command>& commands);

}  // namespace lichtenberg
