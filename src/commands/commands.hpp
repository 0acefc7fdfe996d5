#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lichtenberg {

/// What is asked of an argument beside its type.
struct ArgumentRule {
  bool required = false;
  bool positive = false;
  bool comma_separated = false;      ///< a list in one word
  bool repeated = false;             ///< a list of which each value has the option's name before it
  bool default_shown = false;        ///< in the help: what the target holds
  bool value_optional = false;       ///< of a text, as in --json or --json=FILE; without a value it becomes "true"
  bool value_follows = false;        ///< beside: the next word is that value unless it begins with a dash
  std::vector<std::string> allowed;  ///< values; empty: all
  std::vector<std::string> offered;  ///< by completion, of a word that may be any
  std::string excluded;              ///< an earlier option of the command that cannot be given with this one
};

/// An argument of a subcommand.
struct Argument {
  /// A bool's option has no value.
  using Target = std::variant<bool*, int*, double*, std::string*, std::optional<int>*, std::optional<double>*,
                              std::optional<std::string>*, std::vector<int>*, std::vector<std::string>*>;

  std::string name;  ///< "--out"; without dashes it is told by its place
  Target target;     ///< keeps what it holds if the argument is not given
  std::string help;
  ArgumentRule rule;
};

struct Command {
  std::string name, help;
  std::vector<Argument> arguments;
  std::function<void()> act;  ///< once the arguments are read; keeps their targets alive
};

// One function a subcommand. Errors leave Command::act as InputError or Failure.

Command run_command();
Command solve_command();
Command explain_command();
Command analyse_command();
Command network_command();

// For the Python package alone, not listed.

Command frame_fields_command();
Command ensemble_members_command();
Command work_precision_methods_command();

}  // namespace lichtenberg
