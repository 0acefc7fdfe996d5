#pragma once

namespace CLI {
class App;
}

namespace lichtenberg {

// One function a subcommand: it declares the subcommand's arguments and what to do once they are read. Errors leave it
// as InputError or Failure.

void add_run(CLI::App& program);
void add_solve(CLI::App& program);
void add_explain(CLI::App& program);
void add_plot(CLI::App& program);
void add_analyse(CLI::App& program);
void add_network(CLI::App& program);
void add_work_precision(CLI::App& program);
void add_ensemble(CLI::App& program);
void add_help(CLI::App& program);

}  // namespace lichtenberg
