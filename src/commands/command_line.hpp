#pragma once

#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// Returns the subcommands of `lichtenberg` that its help lists, except `help` itself.
std::vector<Command> all_commands();

/// Returns the subcommands for the Python package, which the help does not list.
std::vector<Command> unlisted_commands();

/// Executes the command that the arguments name (without the program's name). Returns the exit status: 0; 2 for invalid
/// input; 1 for a failure. For an error, prints one message on standard error.
int run_command_line(std::vector<std::string> arguments, const std::vector<Command>& commands = all_commands());

}  // namespace lichtenberg
