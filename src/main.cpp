#include "solvers/parallel/petsc.hpp"
#include "src/commands/command_line.hpp"

int main(int argc, char** argv) {
  const int status = lichtenberg::run_command_line({argv + 1, argv + argc});
  lichtenberg::parallel::finish_petsc();
  return status;
}
