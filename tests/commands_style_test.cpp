// Tests of the tables of commands: one style of arguments in all commands. Each exception states its reason.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "src/commands/command_line.hpp"
#include "src/commands/self_description.hpp"
#include "tests/folder.hpp"
#include "tests/source_folder.hpp"

namespace commands_style_test {

using namespace lichtenberg;

bool is_option(const Argument& argument) { return argument.name.starts_with("-"); }

bool has(const Command& command, const std::string& name) {
  return std::ranges::find(command.arguments, name, &Argument::name) != command.arguments.end();
}

/// Returns "flag", "integer", "number" or "text", also for lists and for options without a default.
std::string kind_of(const Argument& argument) {
  return std::visit(
      []<class T>(T*) {
        if (std::is_same_v<T, bool>) return "flag";
        if (std::is_same_v<T, int> || std::is_same_v<T, std::optional<int>> || std::is_same_v<T, std::vector<int>>)
          return "integer";
        if (std::is_same_v<T, double> || std::is_same_v<T, std::optional<double>>) return "number";
        return "text";
      },
      argument.target);
}

bool is_list(const Argument& argument) {
  return std::holds_alternative<std::vector<int>*>(argument.target) ||
         std::holds_alternative<std::vector<std::string>*>(argument.target);
}

/// Returns the help text up to the first mark. Details of a command may follow the mark.
std::string start_of(const std::string& help) {
  return help.substr(0, std::min({help.find(" ("), help.find(':'), help.find(';'), help.find(',')}));
}

TEST_CASE("option names: long, lower-case words joined by hyphens") {
  for (const Command& command : all_commands())
    for (const Argument& argument : command.arguments) {
      CAPTURE(command.name + " " + argument.name);
      if (!is_option(argument)) {
        CHECK(std::ranges::all_of(argument.name, [](char c) { return c >= 'A' && c <= 'Z'; }));
        continue;
      }
      const std::string name = argument.name.substr(std::min<std::size_t>(2, argument.name.size()));
      CHECK(argument.name.starts_with("--"));
      CHECK(name.size() > 1);
      CHECK(name.front() != '-');
      CHECK(name.back() != '-');
      CHECK(std::ranges::all_of(name, [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; }));
    }
}

TEST_CASE("help texts: present, without a full stop at the end") {
  for (const Command& command : all_commands()) {
    CAPTURE(command.name);
    CHECK_FALSE(command.help.empty());
    CHECK_FALSE(command.help.ends_with('.'));
    for (const Argument& argument : command.arguments) {
      CAPTURE(argument.name);
      CHECK_FALSE(argument.help.empty());
      CHECK((!argument.help.ends_with('.') || argument.help.ends_with("...")));
    }
  }
}

TEST_CASE("argument of several commands: one kind of value, one start of its help") {
  const std::set<std::string> has_own_kind = {
      "--out",  // begins with the kind of file that the command writes
  };
  std::map<std::string, std::pair<std::string, const Argument*>> first;
  const std::vector<Command> commands = all_commands();
  for (const Command& command : commands)
    for (const Argument& argument : command.arguments) {
      const auto [known, is_new] = first.try_emplace(argument.name, command.name, &argument);
      INFO(argument.name << " of " << command.name << " and " << known->second.first);
      const Argument& other = *known->second.second;
      CHECK(kind_of(argument) == kind_of(other));
      CHECK(argument.rule.allowed == other.rule.allowed);
      CHECK(argument.rule.value_optional == other.rule.value_optional);
      if (!has_own_kind.contains(argument.name)) CHECK(start_of(argument.help) == start_of(other.help));
    }
}

TEST_CASE("option with several values: separated by commas or repeated") {
  for (const Command& command : all_commands())
    for (const Argument& argument : command.arguments)
      if (is_option(argument) && is_list(argument))
        CHECK_MESSAGE(argument.rule.comma_separated != argument.rule.repeated, command.name << " " << argument.name);
}

TEST_CASE("files of the command line: SCENE is a scene, RESULT a result") {
  for (const Command& command : all_commands())
    for (const Argument& argument : command.arguments) {
      if (is_option(argument)) continue;
      CAPTURE(command.name + " " + argument.name);
      CHECK((argument.name == "SCENE") == argument.help.starts_with("scene file (.toml)"));
      CHECK((argument.name == "RESULT") == argument.help.starts_with("result file of a run (.h5)"));
    }
}

TEST_CASE("--json: in each command that reports numbers") {
  const std::set<std::string> without_numbers = {"plot", "film", "view", "export"};  // they write files
  for (const Command& command : all_commands()) {
    CAPTURE(command.name);
    CHECK(has(command, "--json") != without_numbers.contains(command.name));
    for (const Argument& argument : command.arguments)
      if (argument.name == "--json") CHECK(argument.rule.value_optional);
  }
}

TEST_CASE("--out, --overwrite: in each command that writes files") {
  const std::set<std::string> without_out = {
      "analyse",  // stores in RESULT; --csv and --json name further files
      "explain",  // prints
  };
  const std::set<std::string> without_overwrite = {
      "ensemble",  // continues its folder and replaces its own table only
  };
  for (const Command& command : all_commands()) {
    CAPTURE(command.name);
    CHECK(has(command, "--out") != without_out.contains(command.name));
    CHECK(has(command, "--overwrite") != without_overwrite.contains(command.name));
  }
}

TEST_CASE("commands that read a scene: have --set; those with SCENE have --device") {
  for (const Command& command : all_commands()) {
    CAPTURE(command.name);
    CHECK(has(command, "--set") == (has(command, "SCENE") || has(command, "--scene")));
    if (command.name == "work-precision") continue;  // compares methods of both devices
    CHECK(has(command, "--device") == has(command, "SCENE"));
  }
}

TEST_CASE("completion and manual page: have each command, option and value") {
  const std::vector<Command> commands = all_commands();
  const std::string completion = bash_completion(commands), page = manual_page(commands);
  for (const Command& command : commands) {
    CAPTURE(command.name);
    const std::size_t begin = completion.find("\n    " + command.name + ") options=\"--help ");
    REQUIRE(begin != std::string::npos);
    const std::string line = completion.substr(begin + 1, completion.find('\n', begin + 1) - begin);
    CHECK(contains(page, ".SS "));
    for (const Argument& argument : command.arguments) {
      CAPTURE(argument.name);
      if (!is_option(argument)) continue;
      CHECK((contains(line, " " + argument.name + " ") || contains(line, " " + argument.name + "\"")));
      if (kind_of(argument) == "flag") continue;
      const std::size_t at = completion.find("\"" + command.name + " " + argument.name + "=\") words=\"");
      REQUIRE(at != std::string::npos);
      const std::string values = completion.substr(at, completion.find('\n', at) - at);
      for (const std::string& value : argument.rule.allowed) CHECK(contains(values, value));
      for (const std::string& value : argument.rule.offered) CHECK(contains(values, value));
    }
  }
}

TEST_CASE("exit status: docs/errors.md states the values of the help") {
  const std::string page = text_of(source_folder() + "/docs/errors.md");
  for (const std::string part : {"## Exit status", "|0|", "|1|", "|2|", "|130|", "|143, 129|"})
    CHECK(contains(page, part));
}

}  // namespace commands_style_test
