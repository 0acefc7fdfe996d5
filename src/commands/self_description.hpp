#pragma once

#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// A script for bash that completes commands, their options and names of files.
std::string bash_completion(const std::vector<Command>& commands);

/// A manual page (roff, for man) of all commands.
std::string manual_page(const std::vector<Command>& commands);

}  // namespace lichtenberg
