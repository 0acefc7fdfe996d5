// Charge balance over whole runs, from the start of a tree to its stationary state. The charge on conductors plus the
// charge collected by the ground equals the injected charge N J t at every frame and through every contact change.
//
//   charge_balance         the seedling, 36 conductors
//   charge_balance long    the dendrite, 324 conductors, on S = 256

#include "src/effects/current_injection.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace charge_balance_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

void run(Report& report, Scene scene) {
  Simulation simulation(scene);
  const double current =
      scene.effects.find<effects::CurrentInjectionOptions>()->current * static_cast<double>(scene.conductors.size());
  std::vector<double> unbalanced, injection_error;
  ConductorFrame frame = simulation.now();
  while (!simulation.stationary() && frame.time < scene.stop.time) {
    simulation.advance_to(frame.time + scene.output.every);
    frame = simulation.now();
    const double injected = current * frame.time;
    unbalanced.push_back((frame.charge_held + frame.charge_drained - frame.charge_fed) / injected);
    injection_error.push_back((frame.charge_fed - injected) / injected);
  }
  const Counters& counters = simulation.counters();
  report.section(fmt::format("{}: {} conductors, {} frames to t = {:.3g} s; {} contacts made, {} lost", scene.title,
                             scene.conductors.size(), unbalanced.size(), frame.time, counters.contacts_made,
                             counters.contacts_lost));
  // Compensated sums leave a few roundings of 1e-16; a plain sum would lose 1e-11.
  report.at_most("stored + collected - injected, fraction of injected", spread(unbalanced), 1e-12);
  report.at_most("injected - N J t, fraction of N J t", spread(injection_error), 1e-12);
  report.at_least("contacts made and lost (or nothing was tested)",
                  static_cast<double>(counters.contacts_made + counters.contacts_lost), 10);
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Charge balance of whole runs");
  const std::string scenes = source_folder() + "/scenes/";
  run(report, read_scene(scenes + "seedling.toml"));
  if (long_run_requested(argc, argv)) {
    Scene dendrite = read_scene(scenes + "dendrite.toml");
    dendrite.field().cells = 256;
    run(report, std::move(dendrite));
  }
  return report.exit_status();
}

const lichtenberg::validation::Program program("charge_balance", validate);

}  // namespace charge_balance_validation
