#pragma once

#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// Returns all names of an argument of a command: its own, then aliases and former names that no other argument of the
/// command has.
std::vector<std::string> names_of(const Argument& argument, const Command& command);

/// Makes a bash script that completes commands, options, their allowed values and file names.
std::string bash_completion(const std::vector<Command>& commands);

/// Makes a manual page (roff) of all commands.
std::string manual_page(const std::vector<Command>& commands);

}  // namespace lichtenberg
