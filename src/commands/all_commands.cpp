#include "src/commands/command_line.hpp"
#include "src/commands/python.hpp"
#include "src/commands/theory_kind.hpp"

namespace lichtenberg {

std::vector<Command> all_commands() {
  std::vector<Command> commands = python_commands();
  commands.insert(commands.begin(), {run_command(), solve_command(), explain_command()});
  commands.insert(commands.end(), {analyse_command(), network_command(), theory_command(theory_kinds())});
  return commands;
}

std::vector<Command> unlisted_commands() {
  return {frame_fields_command(), ensemble_members_command(), work_precision_methods_command()};
}

}  // namespace lichtenberg
