#include "src/commands/command_line.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <new>
#include <sstream>
#include <type_traits>
#include <variant>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/shares.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/parallel/processes.hpp"
#include "src/commands/python.hpp"
#include "src/commands/self_description.hpp"
#include "src/commands/streams.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/scene.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

/// Removes `--petsc` and all following words from the arguments and returns the latter. PETSc's options look like
/// options of this program with one dash, so the parser must not see them.
std::vector<std::string> take_petsc_options(std::vector<std::string>& arguments) {
  const auto mark = std::find(arguments.begin(), arguments.end(), "--petsc");
  if (mark == arguments.end()) return {};
  std::vector<std::string> options(mark + 1, arguments.end());
  arguments.erase(mark, arguments.end());
  return options;
}

void check_command(const CLI::App& program, const std::string& command) {
  std::vector<std::string> known;
  for (const CLI::App* subcommand : program.get_subcommands({})) known.push_back(subcommand->get_name());
  if (std::find(known.begin(), known.end(), command) != known.end()) return;
  if (const std::optional<std::string> meant = likely(command, known))
    throw InputError(
        fmt::format("there is no command `{}`; did you mean `{}`? `lichtenberg help` lists them all", command, *meant));
  throw InputError(fmt::format("there is no command `{}`; `lichtenberg help` lists them all", command));
}

/// Throws InputError for `--between=` and `--json=`. CLI11 takes the next word as the value of the former and treats
/// the latter as a flag.
void check_empty_values(const std::vector<std::string>& arguments) {
  for (const std::string& word : arguments)
    if (word.starts_with("--") && word.find('=') == word.size() - 1)
      throw InputError(fmt::format("option {}: the value is empty", word));
}

/// Former names of options by command.
struct FormerName {
  const char *command, *former, *name;
};
constexpr std::array<FormerName, 5> former_names{{{"network", "--between", "--terminals"},
                                                  {"network", "--spot", "--contact-radius"},
                                                  {"network", "--resistance_per_length", "--resistance-per-length"},
                                                  {"network", "--sheet_resistance", "--sheet-resistance"},
                                                  {"solve", "--picture", "--out"}}};

bool is_option(const std::string& word, const std::string& name) {
  return word == name || word.starts_with(name + "=");
}

/// Replaces former names of options and prints a warning. Throws InputError if both names of an option are given.
void replace_former_names(std::vector<std::string>& arguments, const std::vector<Command>& commands) {
  for (const auto& [command, former, name] : former_names) {
    if (arguments.front() != command) continue;
    const auto called = std::ranges::find(commands, command, &Command::name);
    if (called == commands.end()) continue;
    const std::vector<std::string> names =
        names_of(*std::ranges::find(called->arguments, name, &Argument::name), *called);
    const bool has_name = std::ranges::any_of(arguments, [&](const std::string& word) {
      return std::ranges::any_of(names, [&](const std::string& each) { return is_option(word, each); });
    });
    for (std::string& word : arguments) {
      if (!is_option(word, former)) continue;
      if (has_name) throw InputError(fmt::format("option {} is an old name of {}: give only {}", former, name, name));
      fmt::print(stderr, "lichtenberg: {} is an old name: it is called {} now\n", former, name);
      word.replace(0, std::string(former).size(), name);
    }
  }
}

/// Throws InputError for a repeated `--json`, which CLI11 treats as a flag. `name`: an option with an optional value.
void check_optional_value(const std::vector<std::string>& arguments, const std::string& name) {
  int count = 0;
  for (const std::string& word : arguments)
    if (is_option(word, name)) ++count;
  if (count > 1) throw InputError(fmt::format("option {} is given {} times, but only once is allowed", name, count));
}

/// Joins `--json FILE` to `--json=FILE` if the word after such an option is its value, because CLI11 never takes it as
/// such.
void join_optional_values(std::vector<std::string>& arguments, const std::vector<Command>& commands) {
  const auto command = std::ranges::find(commands, arguments.front(), &Command::name);
  if (command == commands.end()) return;
  for (const Argument& argument : command->arguments)
    if (argument.rule.value_optional) check_optional_value(arguments, argument.name);
  for (std::size_t k = 1; k + 1 < arguments.size(); ++k) {
    const auto argument = std::ranges::find(command->arguments, arguments[k], &Argument::name);
    if (argument == command->arguments.end() || !argument->rule.value_optional) continue;
    const std::string& next = arguments[k + 1];
    if (next.starts_with('-') || !next.ends_with(".json")) continue;
    arguments[k] += "=" + next;
    arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(k) + 1);
  }
}

CLI::Option* add(CLI::App& subcommand, const std::string& names, const Argument& argument) {
  return std::visit(
      [&]<class Target>(Target* target) {
        if constexpr (std::is_same_v<Target, bool>) return subcommand.add_flag(names, *target, argument.help);
        if constexpr (std::is_same_v<Target, std::string>)
          if (argument.rule.value_optional)
            return subcommand.add_flag(names, *target, argument.help)->option_text("[=FILE]");
        return subcommand.add_option(names, *target, argument.help);
      },
      argument.target);
}

void declare(CLI::App& subcommand, const Command& command, const Argument& argument) {
  CLI::Option* option = add(subcommand, fmt::format("{}", fmt::join(names_of(argument, command), ",")), argument);
  const ArgumentRule& rule = argument.rule;
  option->required(rule.required);
  if (option->get_type_size() > 0)  // a flag has no value
    option->check([](const std::string& value) { return value.empty() ? "the value is empty" : ""; });
  if (rule.positive)
    option->check([](const std::string& value) {
      return CLI::PositiveNumber(value).empty() ? "" : value + " is not allowed: it must be a number above 0";
    });
  if (rule.comma_separated) option->delimiter(',');
  if (rule.repeated) option->take_all()->allow_extra_args(false);
  if (rule.default_shown) option->capture_default_str();
  if (!rule.allowed.empty()) option->check(CLI::IsMember(rule.allowed));
  if (!rule.excluded.empty()) option->excludes(subcommand.get_option(rule.excluded));
}

void declare(CLI::App& program, const Command& command) {
  CLI::App* subcommand = program.add_subcommand(command.name, command.help);
  for (const Argument& argument : command.arguments) declare(*subcommand, command, argument);
  subcommand->callback(command.act);
}

bool is_part_of_scene(const std::string& word) {
  try {
    return !scene_help(word).empty();
  } catch (const InputError&) {
    return false;
  }
}

[[noreturn]] void refuse_topic(const std::string& topic, const std::vector<std::string>& topics) {
  std::optional<std::string> meant = likely(topic, topics);
  if (is_part_of_scene(topic)) meant = "help scene " + topic;
  const std::string all = fmt::format("{}", fmt::join(topics, ", "));
  if (meant)
    throw InputError(fmt::format(
        "there is no help on `{}`; did you mean `{}`? The topics are {}; `help scene` has tables and keys of a scene",
        topic, *meant, all));
  throw InputError(fmt::format(
      "there is no help on `{}`. The topics are {}; `help scene` has tables and keys of a scene", topic, all));
}

std::vector<Command> described_commands();

std::string help_text(const CLI::App& program, const std::string& topic, const std::string& part) {
  if (!part.empty() && topic != "scene")
    throw InputError(
        fmt::format("help {} {} is not valid: only `help scene` has parts, as in `help scene field`", topic, part));
  // program.help() would pass the request on to the subcommand in use, which is `help` itself.
  if (topic.empty())
    return program.get_formatter()->make_help(&program, program.get_name(), CLI::AppFormatMode::Normal);
  if (topic == "scene") return scene_help(part);
  if (topic == "completion") return bash_completion(described_commands());
  if (topic == "man") return manual_page(described_commands());
  std::vector<std::string> topics{"scene", "completion", "man"};
  for (const CLI::App* command : program.get_subcommands({})) {
    if (command->get_name() == topic) return command->help(program.get_name());
    topics.push_back(command->get_name());
  }
  refuse_topic(topic, topics);
}

/// Returns the names of the tables of a scene and of the effects.
std::vector<std::string> scene_tables() {
  std::vector<std::string> names;
  std::istringstream lines(scene_help());
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('[')) continue;
    const std::string name = line.substr(line.rfind('[') + 1, line.find(']') - line.rfind('[') - 1);
    names.push_back(name.starts_with("effects.") ? name.substr(8) : name);
  }
  return names;
}

/// Returns the command `help`. `program`: the parser whose help it prints; null if the command is only described.
Command help_command(const CLI::App* program, const std::vector<Command>& commands) {
  auto words = std::make_shared<std::array<std::string, 2>>();
  auto& [topic, part] = *words;
  std::vector<std::string> topics{"scene", "completion", "man"};
  for (const Command& command : commands) topics.push_back(command.name);
  return {"help",
          "Explains a command, or with `help scene` every key of a scene file",
          {{"TOPIC",
            &topic,
            "a command, scene, completion (a script for bash) or man (a manual page)",
            {.offered = topics}},
           {"PART",
            &part,
            "of a scene: a table, an effect or a key, as in `help scene field`",
            {.offered = program ? std::vector<std::string>() : scene_tables()}}},
          [program, words] { fmt::print("{}", help_text(*program, (*words)[0], (*words)[1])); }};
}

/// Returns all commands with `help`, for completion and the manual page. They are not run.
std::vector<Command> described_commands() {
  std::vector<Command> commands = all_commands();
  commands.push_back(help_command(nullptr, commands));
  return commands;
}

void declare(CLI::App& program, const std::vector<Command>& commands) {
  const Version version = lichtenberg_version();
#ifdef LICHTENBERG_REPEATABLE
  constexpr const char* repeatable = ", repeatable";
#else
  constexpr const char* repeatable = "";
#endif
  program.set_version_flag("--version",
                           fmt::format("lichtenberg {} ({}{})", version.number, version.commit, repeatable));
  program.require_subcommand(1);
  program.footer(
      "To begin: write a scene with the keys of `lichtenberg help scene`, or copy one from scenes/ of the "
      "source\n(share/lichtenberg/scenes where it is installed); then explain, run or solve it.\nEverything after "
      "--petsc goes to PETSc, as in --petsc -field_ksp_view.\n" +
      std::string(exit_status_help));
  for (const Command& command : commands) declare(program, command);
  declare(program, help_command(&program, commands));
}

/// Throws InputError for the first argument that the command does not have.
[[noreturn]] void refuse_rest(const CLI::App& program, const std::string& help) {
  const CLI::App* command = program.get_subcommands().empty() ? &program : program.get_subcommands().front();
  const std::string word = program.remaining(true).front(), name = word.substr(0, word.find('='));
  if (!name.starts_with('-'))
    throw InputError(fmt::format("the command {} does not take `{}`; see `{}` for the allowed arguments",
                                 command->get_name(), word, help));
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& each : option->get_lnames()) known.push_back(each);
  const std::size_t begin = name.find_first_not_of('-');
  const std::optional<std::string> meant =
      begin == std::string::npos ? std::nullopt : likely(name.substr(begin), known);
  if (meant)
    throw InputError(
        fmt::format("the command {} has no option {}; did you mean --{}? see `{}` for the allowed arguments",
                    command->get_name(), name, *meant, help));
  throw InputError(fmt::format("the command {} has no option {}; see `{}` for the allowed arguments",
                               command->get_name(), name, help));
}

/// Adds the unlisted command that the arguments name, or for which they request help.
void add_unlisted(std::vector<Command>& commands, const std::vector<std::string>& arguments) {
  const std::size_t word_index = !arguments.empty() && arguments.front() == "help" ? 1 : 0;
  if (arguments.size() <= word_index ||
      std::ranges::find(commands, arguments[word_index], &Command::name) != commands.end())
    return;
  for (const Command& inner : unlisted_commands()) {
    if (inner.name != arguments[word_index]) continue;
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // the parent process alone reads the output
    return commands.push_back(inner);
  }
  if (std::optional<Command> added = added_python_command(arguments[word_index])) commands.push_back(std::move(*added));
}

void dispatch(std::vector<std::string> arguments, std::vector<Command> commands) {
  add_unlisted(commands, arguments);
  CLI::App program("Charged conductors in a dielectric: how they move, touch, exchange charge and form structures.",
                   "lichtenberg");
  declare(program, commands);
  if (arguments.empty()) throw InputError("no command was given; `lichtenberg help` lists them");
  std::string help = "lichtenberg help";
  if (!arguments.front().starts_with('-')) {
    check_command(program, arguments.front());
    help += " " + arguments.front();
  }
  check_empty_values(arguments);
  replace_former_names(arguments, commands);
  join_optional_values(arguments, commands);
  try {
    std::reverse(arguments.begin(), arguments.end());  // CLI11 reads the arguments from the back
    program.parse(arguments);
  } catch (const CLI::Success& request) {
    std::ostringstream words;
    program.exit(request, words, words);  // --help, --version
    fmt::print("{}", words.str());
  } catch (const CLI::ExtrasError&) {
    refuse_rest(program, help);
  } catch (const CLI::ParseError& error) {
    throw InputError(
        fmt::format("the arguments are not valid: {}; see `{}` for the allowed arguments", error.what(), help));
  }
}

void warn_of_unused_options() {
  for (const std::string& option : parallel::unused_petsc_options())
    fmt::print(stderr, "lichtenberg: the option {} after --petsc was not used (misspelt?)\n", printable(option));
}

/// Throws Failure if required output could not be written. For optional output, prints a message on standard error.
void finish_output() {
  const int error = output_error();
  if (error == 0 || closed_pipe_ends_program()) return;  // run_command_line() ends the program without a message
  const Failure failure(fmt::format("the output could not be written ({})", std::strerror(error)));
  if (!is_output_optional()) throw failure;
  fmt::print(stderr, "lichtenberg: {}, but the files that it names are complete\n", printable(failure.what()));
}

int report(const std::exception& error, int status) {
  fmt::print(stderr, "lichtenberg: {}\n", printable(error.what()));
  return status;
}

/// Raises the limit of open files. Throws Failure if it stays so low that libraries would end the program.
void ensure_open_files() {
  constexpr rlim_t wanted = 1024, least = 64;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= wanted) return;
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  setrlimit(RLIMIT_NOFILE, &limit);
  if (limit.rlim_cur < least)
    throw Failure(fmt::format("only {} files may be open at once (ulimit -n), and at least {} are needed",
                              limit.rlim_cur, least));
}

/// Reports a failed HDF5 call that the command did not catch. If the words name a single existing result file (.h5),
/// the message names that file.
int report_hdf5(const hdf5::Error& error, const std::vector<std::string>& words) {
  std::vector<std::string> results;
  for (const std::string& word : words) {
    const std::string path = word.starts_with('-') ? word.substr(word.find('=') + 1) : word;
    if (std::error_code none; path.ends_with(".h5") && std::filesystem::is_regular_file(path, none))
      results.push_back(path);
  }
  if (results.size() == 1)
    return report(
        InputError(fmt::format("the input file {} is damaged or incomplete ({})", results.front(), error.what())), 2);
  return report(Failure(fmt::format("an HDF5 file could not be read or written ({})", error.what())), 1);
}

/// Returns the exit status of `work`, or of its exception, for a command line of these words.
int status_of(const std::function<int()>& work, const std::vector<std::string>& words) {
  try {
    return work();
  } catch (const InputError& error) {
    return report(error, 2);
  } catch (const hdf5::Error& error) {
    return report_hdf5(error, words);
  } catch (const std::bad_alloc&) {
    return report(
        Failure("this machine has too little memory for that; `lichtenberg explain SCENE` says how much a scene "
                "takes, and a smaller field.cells or population.count takes less"),
        1);
  } catch (const std::exception& error) {
    return report(error, 1);
  }
}

}  // namespace

int run_command_line(std::vector<std::string> arguments, const std::vector<Command>& commands) {
  const std::vector<std::string> words = arguments;
  prepare_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the file size limit then fails with an error message
  const int status = status_of(
      [&] {
        ensure_open_files();
        parallel::set_petsc_options(take_petsc_options(arguments));
        laplace::SolverShares shares;
        const bool first = parallel::join_processes([&](parallel::Message& message) { shares(message); });
        if (!first) return 0;  // a worker process of mpirun
        // the PETSc options apply to the run
        const bool explains = !arguments.empty() && arguments.front() == "explain";
        dispatch(std::move(arguments), commands);
        if (!explains) warn_of_unused_options();
        finish_output();
        return 0;
      },
      words);
  parallel::dismiss_processes(status != 0);
  if (closed_pipe_ends_program()) end_by_closed_pipe();
  return status;
}

}  // namespace lichtenberg
