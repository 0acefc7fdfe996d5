#include "src/commands/self_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "src/version.hpp"

namespace lichtenberg {
namespace {

/// Alternative spellings and deprecated names.
constexpr std::array<std::pair<const char*, const char*>, 7> other_names{
    {{"--out", "--output"},
     {"--colour", "--color"},
     {"--frames", "--frame"},
     {"--contact-radius", "--spot"},
     {"--terminals", "--between"},
     {"--resistance-per-length", "--resistance_per_length"},
     {"--sheet-resistance", "--sheet_resistance"}}};

bool is_option(const Argument& argument) { return argument.name.starts_with("-"); }
bool is_flag(const Argument& argument) { return std::holds_alternative<bool*>(argument.target); }

std::vector<std::string> allowed_values(const Argument& argument) {
  std::vector<std::string> values = argument.rule.allowed;
  values.insert(values.end(), argument.rule.offered.begin(), argument.rule.offered.end());
  return values;
}

/// Returns the names of options and the allowed values of positional arguments.
std::string words_of(const Command& command) {
  std::vector<std::string> words;
  for (const Argument& argument : command.arguments) {
    const std::vector<std::string> more = is_option(argument) ? names_of(argument, command) : allowed_values(argument);
    words.insert(words.end(), more.begin(), more.end());
  }
  return fmt::format("{}", fmt::join(words, " "));
}

/// Returns shell cases by command and preceding option.
std::string cases_of_values(const Command& command) {
  std::string cases;
  for (const Argument& argument : command.arguments)
    if (is_option(argument) && !allowed_values(argument).empty())
      for (const std::string& name : names_of(argument, command))
        cases +=
            fmt::format("    \"{} {}\") words=\"{}\" ;;\n", command.name, name, fmt::join(allowed_values(argument), " "));
  return cases;
}

std::string value_in_words(const Argument& argument) {
  if (!is_option(argument) || is_flag(argument)) return "";
  return argument.rule.value_optional ? "[=FILE]" : " VALUE";
}

/// Escapes text for roff: dashes that can be copied, backslashes, and leading dots that would be requests.
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
    if (!is_option(argument)) synopsis += argument.rule.required ? " " + argument.name : " [" + argument.name + "]";
    options +=
        fmt::format(".TP\n\\fB{}\\fR{}\n{}\n", roff(fmt::format("{}", fmt::join(names_of(argument, command), ", "))),
                    value_in_words(argument), roff(argument.help));
  }
  return fmt::format(".SS {}{} [OPTIONS]\n{}.\n{}", command.name, synopsis, roff(command.help), options);
}

}  // namespace

std::vector<std::string> names_of(const Argument& argument, const Command& command) {
  std::vector<std::string> names{argument.name};
  for (const auto& [name, other] : other_names)
    if (argument.name == name &&
        std::ranges::find(command.arguments, other, &Argument::name) == command.arguments.end())
      names.emplace_back(other);
  return names;
}

std::string bash_completion(const std::vector<Command>& commands) {
  std::string names, cases, values;
  for (const Command& command : commands) {
    names += (names.empty() ? "" : " ") + command.name;
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command.name, words_of(command));
    values += cases_of_values(command);
  }
  return fmt::format(R"(# Completion of lichtenberg for bash: source this file.
_lichtenberg() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} words="{}" command=
  if [[ $COMP_CWORD -gt 1 ]]; then
    words="" command=${{COMP_WORDS[1]}}
    case $command in
{}    esac
  fi
  local options=$words
  case "$command $before" in
{}  esac
  COMPREPLY=($(compgen -W "$words" -- "$current"))
  if [[ $words == "$options" && $command && $command != help && $current != -* ]]; then
    COMPREPLY+=($(compgen -f -- "$current"))
  fi
}}
complete -o filenames -F _lichtenberg lichtenberg ./lichtenberg
)",
                     names, cases, values);
}

std::string manual_page(const std::vector<Command>& commands) {
  std::string text = fmt::format(
      ".TH LICHTENBERG 1 \"\" \"lichtenberg {}\"\n.SH NAME\nlichtenberg \\- charged conductors and grains: how they "
      "move, touch, exchange charge and form structures\n.SH SYNOPSIS\n.B lichtenberg\nCOMMAND [ARGUMENTS] "
      "[\\-\\-petsc OPTIONS]\n.SH DESCRIPTION\nRuns scenes (TOML files) and analyses their results (HDF5 files). "
      "`lichtenberg help scene` lists all that a scene may hold. Exit status: 0 done, 2 for input that cannot be used, "
      "1 for work that could not be done.\n.SH COMMANDS\n",
      lichtenberg_version().number);
  for (const Command& command : commands) text += section_of(command);
  return text;
}

}  // namespace lichtenberg
