#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"
#include "src/commands/theory_tables.hpp"

namespace lichtenberg {

/// Options of `lichtenberg theory` that only some theories have. The command refuses options that TheoryKind::options
/// of the theory does not name.
struct TheoryOptions {
  std::optional<double> restitution, charge_number;
  std::optional<int> cells, seed;
  bool space = false, separated = false;
  std::string field;                       ///< output file for the final fields
  std::string kernel;                      ///< coagulation kernel: brownian, power:MU,NU or a CSV file
  std::optional<double> repulsion, until;  ///< of that kernel
};

/// Input of a theory of a gas of grains: gas, run for comparison, options.
struct TheoryRequest {
  std::optional<GasParameters> gas;    ///< gas of the scene or result, else TheoryKind::usual_gas; empty without either
  bool gas_is_given = false;           ///< `gas` belongs to a scene or result
  const GasTimeSeries* run = nullptr;  ///< null without a result
  TheoryOptions options;
};

/// Declaration of a theory of a gas of grains for `lichtenberg theory`. To add a theory, write a file with a function
/// that returns its TheoryKind, declare the function below, and add it to theory_kinds().
struct TheoryKind {
  std::string name;
  /// Computes the figures and tables of the theory for a request. Throws InputError for a gas to which the theory does
  /// not apply.
  TheoryAnswer (*answer)(const TheoryRequest&);
  GasParameters (*usual_gas)() = nullptr;  ///< gas without a scene; null: the theory then needs no gas
  std::vector<std::string> options{};      ///< its options of TheoryOptions, such as "--cells"
};

/// Declares the theory `haff`: Haff's law of cooling without charges.
TheoryKind haff_kind();
/// Declares the theory `monopolar`: cooling of grains with equal charges.
TheoryKind monopolar_kind();
/// Declares the theory `restitution`: restitution coefficient of the grains' contacts by impact speed.
TheoryKind restitution_kind();
/// Declares the theory `smoluchowski`: growth of aggregates by Smoluchowski's coagulation equation.
TheoryKind smoluchowski_kind();
/// Computes coagulation with the kernel of these options. Throws InputError for wrong ones and Failure if the solution
/// fails.
TheoryAnswer kernel_growth(const TheoryOptions& options);
/// Declares the theory `kinetic`: kinetic theory of charging and coalescence.
TheoryKind kinetic_kind();
/// Declares the theory `stability`: linear stability of a homogeneous charged gas.
TheoryKind stability_kind();
/// Declares the theory `hydrodynamics`: numerical solution of the hydrodynamic equations.
TheoryKind hydrodynamics_kind();
/// Declares the theory `all`: several theories of one gas in common tables.
TheoryKind all_kind();

/// Returns all theories of `lichtenberg theory`.
const std::vector<TheoryKind>& theory_kinds();

/// Makes the command `theory` for these theories. Its Command::act throws InputError and Failure.
Command theory_command(const std::vector<TheoryKind>& kinds);

/// Returns the restitution coefficient and the dimensionless charge number R (theory::charge_number) for linear
/// stability. They come from the options, else from the gas of a scene or result, else from G 6.1 (f). R is 0 for a gas
/// whose grains exchange charge.
std::pair<double, double> stability_numbers(const TheoryRequest& request);

}  // namespace lichtenberg
