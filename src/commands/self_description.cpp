#include "src/commands/self_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>
#include <variant>

#include "src/version.hpp"

namespace lichtenberg {
namespace {

/// Alternative names.
constexpr std::array<std::pair<const char*, const char*>, 3> other_names{
    {{"--out", "--output"}, {"--colour", "--color"}, {"--frames", "--frame"}}};

/// Patterns of the files that complete an argument.
constexpr std::array<std::pair<const char*, const char*>, 8> file_patterns{{{"SCENE", "*.toml"},
                                                                            {"--scene", "*.toml"},
                                                                            {"RESULT", "*.h5"},
                                                                            {"--from", "*.h5"},
                                                                            {"--out", "*"},
                                                                            {"--json", "*"},
                                                                            {"--csv", "*"},
                                                                            {"--field", "*"}}};

bool is_option(const Argument& argument) { return argument.name.starts_with("-"); }
bool is_flag(const Argument& argument) { return std::holds_alternative<bool*>(argument.target); }

bool takes_text(const Argument& argument) {
  return std::visit(
      []<class Target>(Target*) {
        return std::is_same_v<Target, std::string> || std::is_same_v<Target, std::optional<std::string>> ||
               std::is_same_v<Target, std::vector<std::string>>;
      },
      argument.target);
}

std::vector<std::string> allowed_values(const Argument& argument) {
  std::vector<std::string> values = argument.rule.allowed;
  values.insert(values.end(), argument.rule.offered.begin(), argument.rule.offered.end());
  return values;
}

/// Returns the pattern of the files that complete an argument; empty if none do.
std::string files_of(const Argument& argument) {
  if (!allowed_values(argument).empty() || !takes_text(argument)) return "";
  const auto known = std::ranges::find(file_patterns, argument.name, &std::pair<const char*, const char*>::first);
  return known == file_patterns.end() ? "" : known->second;
}

/// Returns a shell case: names of the options, values and files of positional arguments.
std::string case_of(const Command& command) {
  std::vector<std::string> options{"--help"}, values;
  std::string files;
  for (const Argument& argument : command.arguments) {
    if (argument.name == "PART") continue;
    const std::vector<std::string> more = is_option(argument) ? names_of(argument, command) : allowed_values(argument);
    std::vector<std::string>& words = is_option(argument) ? options : values;
    words.insert(words.end(), more.begin(), more.end());
    if (!is_option(argument) && !files_of(argument).empty()) files = files_of(argument);
  }
  return fmt::format("    {}) options=\"{}\" words=\"{}\" files=\"{}\" ;;\n", command.name, fmt::join(options, " "),
                     fmt::join(values, " "), files);
}

/// Returns shell cases by command and the preceding option, of the options that have a value.
std::string cases_of_values(const Command& command) {
  std::string cases;
  for (const Argument& argument : command.arguments) {
    if (argument.name == "PART")  // follows `help scene` only
      cases +=
          fmt::format("    \"{} scene\") words=\"{}\" ;;\n", command.name, fmt::join(allowed_values(argument), " "));
    if (!is_option(argument) || is_flag(argument)) continue;
    for (const std::string& name : names_of(argument, command)) {
      const std::string before = fmt::format("\"{} {}", command.name, name);
      cases += fmt::format("    {}{}=\") words=\"{}\" files=\"{}\" ;;\n",
                           argument.rule.value_optional ? "" : before + "\" | ", before,
                           fmt::join(allowed_values(argument), " "), files_of(argument));
    }
  }
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
    cases += case_of(command);
    values += cases_of_values(command);
  }
  return fmt::format(R"(# Completion of lichtenberg for bash: source this file.
_lichtenberg() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} command= word=
  local words="{}" options="--help --version" files=
  # bash makes --device=cpu three words
  [[ $current == = ]] && before=$before= current=
  [[ $before == = ]] && before=${{COMP_WORDS[COMP_CWORD - 2]}}=
  if [[ $COMP_CWORD -gt 1 ]]; then
    words= options= command=${{COMP_WORDS[1]}}
    case $command in
{}    esac
    # the theory or topic is given once
    for word in "${{COMP_WORDS[@]:2:COMP_CWORD-2}}"; do
      [[ " $words " == *" $word "* ]] && words=
    done
  fi
  case "$command $before" in
{}  esac
  [[ $current == -* && $before != *= ]] && words=$options files=
  mapfile -t COMPREPLY < <(
    compgen -W "$words" -- "$current"
    [[ $files ]] && compgen -d -- "$current"
    [[ $files ]] && compgen -f -X "!$files" -- "$current")
  # a file may have another ending
  [[ $files && ${{#COMPREPLY[@]}} == 0 ]] && mapfile -t COMPREPLY < <(compgen -f -- "$current")
  return 0
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
      "`lichtenberg help scene` lists all that a scene may hold.\n.SH COMMANDS\n",
      lichtenberg_version().number);
  for (const Command& command : commands) text += section_of(command);
  return text + ".SH EXIT STATUS\n" + roff(std::string(exit_status_help)) + "\n";
}

}  // namespace lichtenberg
