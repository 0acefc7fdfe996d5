#include "src/commands/self_description.hpp"

#include <fmt/format.h>

#include <variant>

#include "src/version.hpp"

namespace lichtenberg {
namespace {

bool is_option(const Argument& argument) { return argument.name.starts_with("-"); }
bool is_flag(const Argument& argument) { return std::holds_alternative<bool*>(argument.target); }

std::string options_of(const Command& command) {
  std::string words;
  for (const Argument& argument : command.arguments)
    if (is_option(argument)) words += (words.empty() ? "" : " ") + argument.name;
  return words;
}

/// Text as roff has it: a dash that can be copied, no backslash and no dot that would be a request.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
  }
  return result.starts_with('.') || result.starts_with('\'') ? "\\&" + result : result;
}

std::string section_of(const Command& command) {
  std::string synopsis, options;
  for (const Argument& argument : command.arguments) {
    const std::string value = is_option(argument) && !is_flag(argument) ? " VALUE" : "";
    if (!is_option(argument)) synopsis += argument.rule.required ? " " + argument.name : " [" + argument.name + "]";
    options += fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(argument.name), value, roff(argument.help));
  }
  return fmt::format(".SS {}{} [OPTIONS]\n{}.\n{}", command.name, synopsis, roff(command.help), options);
}

}  // namespace

std::string bash_completion(const std::vector<Command>& commands) {
  std::string names, cases;
  for (const Command& command : commands) {
    names += command.name + " ";
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command.name, options_of(command));
  }
  return fmt::format(R"(# Completion of lichtenberg for bash: source this file.
_lichtenberg() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} words="{}help"
  if [[ $COMP_CWORD -gt 1 ]]; then
    words=""
    case ${{COMP_WORDS[1]}} in
{}    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "$current"))
  if [[ $COMP_CWORD -gt 1 && $current != -* ]]; then COMPREPLY=($(compgen -f -- "$current")); fi
}}
complete -o filenames -F _lichtenberg lichtenberg ./lichtenberg
)",
                     names, cases);
}

std::string manual_page(const std::vector<Command>& commands) {
  std::string text = fmt::format(
      ".TH LICHTENBERG 1 \"\" \"lichtenberg {}\"\n"
      ".SH NAME\nlichtenberg \\- charged conductors and grains: how they move, touch, exchange charge and form "
      "structures\n"
      ".SH SYNOPSIS\n.B lichtenberg\nCOMMAND [ARGUMENTS] [\\-\\-petsc OPTIONS]\n"
      ".SH DESCRIPTION\nRuns scenes, which are TOML files, and looks at their results, which are HDF5 files. "
      "`lichtenberg help scene` lists all that a scene may hold. Exit status: 0 done, 2 for input that cannot be used, "
      "1 "
      "for work that could not be done.\n"
      ".SH COMMANDS\n",
      lichtenberg_version().number);
  for (const Command& command : commands) text += section_of(command);
  return text;
}

}  // namespace lichtenberg
