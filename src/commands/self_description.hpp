#pragma once

#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// All names of an argument of a command: its own, then others by which its option is known too.
std::vector<std::string> names_of(const Argument& argument, const Command& command);

/// A script for bash that completes commands, their options with the values that are allowed, and names of files.
std::string bash_completion(const std::vector<Command>& commands);

/// A manual page (roff, for man) of all commands.
std::string manual_page(const std::vector<Command>& commands);

}  // namespace lichtenberg
