#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"
#include "src/commands/theory_tables.hpp"

namespace lichtenberg {

/// Options of `lichtenberg theory` that some theories take; a theory that does not name one in TheoryKind::options is
/// refused with it.
struct TheoryOptions {
  std::optional<double> restitution, charge_number;
  std::optional<int> cells, seed;
  bool space = false, separated = false;
  std::string field;  ///< file for the last fields
};

/// What a theory is asked about.
struct TheoryRequest {
  std::optional<GasParameters> gas;  ///< of the scene or result, else TheoryKind::usual_gas; empty where there is none
  bool of_scene = false;             ///< whether `gas` belongs to a scene or result
  const GasCourse* run = nullptr;    ///< null without a result
  TheoryOptions options;
};

/// One theory of a gas of grains. A new theory is one file with a function that returns this, and one line in
/// theory_kinds().
struct TheoryKind {
  std::string name;
  /// Throws InputError for a gas for which the theory does not hold.
  TheoryAnswer (*answer)(const TheoryRequest&);
  GasParameters (*usual_gas)() = nullptr;  ///< without a scene; null: the theory then answers without a gas
  std::vector<std::string> options{};      ///< those of TheoryOptions that it takes, as "--cells"
};

TheoryKind haff_kind();
TheoryKind monopolar_kind();
TheoryKind restitution_kind();
TheoryKind smoluchowski_kind();
TheoryKind kinetic_kind();
TheoryKind stability_kind();
TheoryKind hydrodynamics_kind();
TheoryKind all_kind();

const std::vector<TheoryKind>& theory_kinds();

/// The command `theory` for these theories. Throws InputError and Failure from Command::act.
Command theory_command(const std::vector<TheoryKind>& kinds);

/// Restitution and R: those of the options, else of the scene's gas, else those of G 6.1 (f).
std::pair<double, double> stability_numbers(const TheoryRequest& request);

}  // namespace lichtenberg
