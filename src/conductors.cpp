// The program lichtenberg_conductors: runs of conductors, and pictures of them. It is the program lichtenberg without
// its other commands and the effects of grains and packings, so that it takes less time to build. The script
// `lichtenberg` alone calls it, for the first commands in a new clone. The functions below replace those of the
// libraries that it leaves out.
#include <set>

#include "solvers/parallel/petsc.hpp"
#include "src/commands/command_line.hpp"
#include "src/commands/motion_kind.hpp"
#include "src/commands/python.hpp"
#include "src/effects/effects.hpp"

namespace lichtenberg {

const EffectKinds& effects::all_kinds() {
  static const EffectKinds kinds = conductor_kinds();
  return kinds;
}

const std::vector<MotionKind>& motion_kinds() {
  static const std::vector<MotionKind> kinds = {conductor_motion()};
  return kinds;
}

std::vector<Command> all_commands() {
  static const std::set<std::string> result_commands = {"plot", "film", "view", "export"};
  std::vector<Command> commands = {run_command()};
  for (Command& command : python_commands())
    if (result_commands.contains(command.name)) commands.push_back(std::move(command));
  return commands;
}

std::vector<Command> unlisted_commands() { return {frame_fields_command()}; }

}  // namespace lichtenberg

int main(int argc, char** argv) {
  const int status = lichtenberg::run_command_line({argv + 1, argv + argc});
  lichtenberg::parallel::finish_petsc();
  return status;
}
