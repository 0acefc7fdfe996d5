#pragma once

#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

std::vector<Command> all_commands();

/// Runs the command that the arguments name (without the program's own name) and returns the exit status: 0, 2 for
/// input that cannot be used, 1 for work that could not be done. Either error is one sentence on standard error.
int run_command_line(std::vector<std::string> arguments, const std::vector<Command>& commands = all_commands());

}  // namespace lichtenberg
