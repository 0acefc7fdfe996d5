#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace lichtenberg {

/// Constraints on an argument of the command line.
struct ArgumentRule {
  bool required = false;
  bool positive = false;
  bool comma_separated = false;      ///< several values in one word
  bool repeated = false;             ///< several values, each after the option's name
  bool default_shown = false;        ///< the help shows the target's initial value
  bool value_optional = false;       ///< for text, as in --json or --json=FILE; without a value the text is "true"
  std::vector<std::string> allowed;  ///< allowed values; empty: all
  std::vector<std::string> offered;  ///< values that completion offers although any word is allowed
  std::string excluded;              ///< an earlier option of the command that cannot be given with this one
};

/// An argument of a subcommand: an option, or a positional argument.
struct Argument {
  /// Pointer to the variable that receives the value. An option of a bool has no value on the command line.
  using Target = std::variant<bool*, int*, double*, std::string*, std::optional<int>*, std::optional<double>*,
                              std::optional<std::string>*, std::vector<int>*, std::vector<std::string>*>;

  std::string name;  ///< such as "--out"; without dashes the argument is positional
  Target target;     ///< unchanged if the argument is not given
  std::string help;
  ArgumentRule rule;
};

/// A subcommand of the program: its name, help, arguments and function.
struct Command {
  std::string name, help;
  std::vector<Argument> arguments;
  std::function<void()> act;  ///< called after the arguments are read; owns their targets
};

// Arguments that several commands have. Their help texts are the same in all commands (tests/commands_style_test.cpp).

/// Makes the argument `--frame`, for commands that read one frame of a result.
inline Argument frame_argument(std::optional<int>& frame) {
  return {"--frame", &frame, "index of the frame, from 0 (default: the last)"};
}

/// Makes the argument `--overwrite`, for commands that write files. `excluded`: see ArgumentRule.
inline Argument overwrite_argument(bool& overwrite, const std::string& excluded = "") {
  return {"--overwrite", &overwrite, "replace files that exist", {.excluded = excluded}};
}

/// Makes the argument `--quiet`. `more`: text for the help about other output that is omitted.
inline Argument quiet_argument(bool& quiet, const std::string& more = "") {
  return {"--quiet", &quiet, "show no progress" + more};
}

// One function makes each subcommand. Command::act throws InputError or Failure.

Command run_command();
Command solve_command();
Command explain_command();
Command analyse_command();
Command network_command();

// Commands for the Python package only; they are not listed.

Command frame_fields_command();
Command ensemble_members_command();
Command work_precision_methods_command();

}  // namespace lichtenberg
