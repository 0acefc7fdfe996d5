#include "src/commands/python.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <variant>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/stopwatch.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/streams.hpp"

namespace lichtenberg {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Returns the path of Python: LICHTENBERG_PYTHON of the environment, else that of the build.
const char* python() {
  const char* named = std::getenv("LICHTENBERG_PYTHON");
  return named && *named ? named : PYTHON;
}

constexpr const char* package_of_wheel = "..";

/// Description of the package's commands (output of `--describe`).
constexpr const char* table =
#include PYTHON_COMMANDS
    ;

/// Returns the package's folder. One next to an installed program comes first, so that an installation does not depend
/// on its source. In a wheel, the package contains the program.
std::optional<fs::path> find_package() {
  // `canonical` would fail for a program that was rebuilt while running, whose link names a deleted file.
  const fs::path program = fs::read_symlink("/proc/self/exe");
  for (const char* relative_path : {PACKAGE_FROM_BINARY, package_of_wheel, PACKAGE_IN_SOURCE}) {
    const fs::path package = program.parent_path() / relative_path;
    if (fs::exists(package / "__main__.py")) return package.lexically_normal();
  }
  return {};
}

/// Returns the words of a command line: Python, the package, then `words`.
std::vector<std::string> command_line(std::vector<std::string> words) {
  const std::optional<fs::path> package = find_package();
  if (!package)
    throw Failure(fmt::format("the Python package lichtenberg is neither in {} relative to {} nor in {}",
                              PACKAGE_FROM_BINARY, fs::read_symlink("/proc/self/exe").string(), PACKAGE_IN_SOURCE));
  words.insert(words.begin(), {python(), (*package / "__main__.py").string()});
  return words;
}

/// Returns a null-terminated array of pointers for exec, valid as long as `words`.
std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> all;
  for (std::string& word : words) all.push_back(word.data());
  all.push_back(nullptr);
  return all;
}

[[noreturn]] void refuse_start(int error) {
  throw Failure(fmt::format("{} does not start ({})", python(), std::strerror(error)));
}

/// Makes the package call this program, even if another is built meanwhile. The file stays open as long as the process
/// lives.
void export_program_path() {
  static const int program = open("/proc/self/exe", O_RDONLY);
  setenv("LICHTENBERG", fmt::format("/proc/{}/fd/{}", getpid(), program).c_str(), 1);
}

/// Runs the package, which ends with this process (interrupted.py), waits for it and returns whether it succeeded. It
/// writes to the descriptors `output` and `errors`. Throws Failure if Python does not start.
bool run_package(std::vector<std::string> words, int output = STDOUT_FILENO, int errors = STDERR_FILENO) {
  std::vector<std::string> command = command_line(std::move(words));
  export_program_path();
  setenv("LICHTENBERG_WAITS", std::to_string(getpid()).c_str(), 1);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO);
  pid_t script = 0;
  const int error = posix_spawn(&script, python(), &actions, nullptr, pointers(command).data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  unsetenv("LICHTENBERG_WAITS");
  if (error != 0) refuse_start(error);
  int status = 0;
  while (waitpid(script, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("lost the process of Python ({})", std::strerror(errno)));
  return status == 0;
}

[[noreturn]] void exec_package(std::vector<std::string> words) {
  std::vector<std::string> command = command_line(std::move(words));
  export_program_path();
  parallel::finish_petsc();  // exec runs no exit handlers
  execv(python(), pointers(command).data());
  refuse_start(errno);
}

/// Value of an argument on the command line.
using Value = std::variant<bool, double, std::string, std::optional<int>, std::optional<double>,
                           std::optional<std::string>, std::vector<int>, std::vector<std::string>>;

struct PythonArgument {
  std::string name;
  /// Participle for messages about the result file that the argument names, as in "drawn"; empty: it names none.
  std::string use_of_result;
  Value value;
};

Value value_of(const json& described) {
  const std::string kind = described.at("kind");
  if (kind == "flag") return false;
  if (kind == "texts") return std::vector<std::string>();
  if (kind == "ints") return std::vector<int>();
  if (kind == "int") return std::optional<int>();
  if (kind == "float" && described.contains("default")) return described.at("default").get<double>();
  if (kind == "float") return std::optional<double>();
  if (described.value("value_optional", false)) return std::string();
  return std::optional<std::string>();
}

/// Returns the value as words for Python; empty if the argument was not given.
std::vector<std::string> words_of(const PythonArgument& argument) {
  const auto word = [&](const auto& value) {
    // the value may begin with a dash
    if (argument.name.starts_with('-')) return fmt::format("{}={}", argument.name, value);
    if constexpr (requires { value.empty(); }) return as_word(value);
    return fmt::format("{}", value);
  };
  return std::visit(
      [&]<class V>(const V& value) -> std::vector<std::string> {
        if constexpr (std::is_same_v<V, bool>) return value ? std::vector{argument.name} : std::vector<std::string>();
        if constexpr (std::is_same_v<V, double>) return {word(value)};
        if constexpr (std::is_same_v<V, std::string>)
          return value.empty() ? std::vector<std::string>() : std::vector{word(value)};
        if constexpr (requires { value.front(); } && !std::is_same_v<V, std::string>) {
          std::vector<std::string> words;
          for (const auto& each : value) words.push_back(word(each));
          return words;
        }
        if constexpr (requires { value.has_value(); })
          return value ? std::vector{word(*value)} : std::vector<std::string>();
      },
      argument.value);
}

/// Throws InputError for damaged result files. Folders and tables (.json) of ensembles are skipped.
void check_results(const std::deque<PythonArgument>& arguments) {
  for (const PythonArgument& argument : arguments) {
    if (argument.use_of_result.empty()) continue;
    const std::vector<std::string> files = words_of(argument);
    read_in_child(files);
    for (const std::string& file : files)
      if (!fs::is_directory(file) && !file.ends_with(".json")) check_bytes(file, argument.use_of_result);
  }
}

void exec_command(const std::string& name, const std::deque<PythonArgument>& arguments) {
  if (!parallel::unused_petsc_options().empty())
    throw InputError(
        fmt::format("the command {} passes no options to PETSc: leave out --petsc and all that follows it", name));
  if (parallel::process_count() > 1)
    throw InputError(fmt::format("the command {} starts processes of its own: leave mpirun out", name));
  check_results(arguments);
  std::vector<std::string> words{name}, positional;
  for (const PythonArgument& argument : arguments)
    std::ranges::move(words_of(argument), std::back_inserter(argument.name.starts_with('-') ? words : positional));
  if (!positional.empty()) words.push_back("--");  // after it Python does not read a negative number as an option
  std::ranges::move(positional, std::back_inserter(words));
  exec_package(std::move(words));
}

Argument argument_of(const json& described, Value& value) {
  const auto texts = [&](const char* key) { return described.value(key, std::vector<std::string>()); };
  const auto is = [&](const char* key) { return described.value(key, false); };
  return {described.at("name"),
          std::visit([](auto& target) { return Argument::Target(&target); }, value),
          described.at("help"),
          {.required = is("required"),
           .positive = is("positive"),
           .comma_separated = is("comma_separated"),
           .repeated = is("repeated"),
           .default_shown = described.contains("default"),
           .value_optional = is("value_optional"),
           .allowed = texts("allowed"),
           .offered = texts("offered"),
           .excluded = described.value("excluded", "")}};
}

Command command_of(const json& described) {
  Command command{described.at("name"), described.at("help"), {}, {}};
  const auto arguments = std::make_shared<std::deque<PythonArgument>>();
  for (const json& each : described.at("arguments")) {
    arguments->push_back({each.at("name"), each.value("result", ""), value_of(each)});
    command.arguments.push_back(argument_of(each, arguments->back().value));
  }
  command.act = [name = command.name, arguments] { exec_command(name, *arguments); };
  return command;
}

/// A file in memory for the output of another process.
class OutputBuffer {
 public:
  OutputBuffer() : descriptor_(memfd_create("output", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw Failure(fmt::format("no file in memory for the output of {}", python()));
  }
  OutputBuffer(const OutputBuffer&) = delete;
  OutputBuffer& operator=(const OutputBuffer&) = delete;
  ~OutputBuffer() { close(descriptor_); }

  int descriptor() const { return descriptor_; }
  std::string text() const {
    std::ifstream file(fmt::format("/proc/self/fd/{}", descriptor_));
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  int descriptor_;
};

/// Returns the error message in the output of the package, without the name of the program before it.
std::string error_message(const std::string& output) {
  const std::string prefix = "lichtenberg: ";
  const std::size_t begin = output.starts_with(prefix) ? prefix.size() : 0;
  return output.substr(begin, output.find_last_not_of('\n') + 1 - begin);
}

/// Returns the folders that may contain command modules added after the build.
std::vector<fs::path> folders_of_commands() {
  std::vector<fs::path> folders;
  if (const std::optional<fs::path> package = find_package()) folders.push_back(*package / "commands");
  const char* listed = std::getenv("LICHTENBERG_COMMANDS");
  std::istringstream list(listed ? listed : "");
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) folders.emplace_back(folder);
  return folders;
}

}  // namespace

std::vector<Command> python_commands() {
  std::vector<Command> commands;
  for (const json& described : json::parse(table)) commands.push_back(command_of(described));
  return commands;
}

std::optional<Command> added_python_command(const std::string& name) {
  const bool plain = std::ranges::all_of(name, [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; });
  std::string module = name + ".py";
  std::ranges::replace(module, '-', '_');
  const auto holds = [&](const fs::path& folder) { return fs::is_regular_file(folder / module); };
  if (!plain || name.starts_with('-') || std::ranges::none_of(folders_of_commands(), holds)) return {};
  const OutputBuffer output, errors;
  if (!run_package({"--describe", name}, output.descriptor(), errors.descriptor())) {
    const std::string sentence = error_message(errors.text());
    throw Failure(sentence.empty() ? fmt::format("{} is not a valid Python command: Python ended early", module)
                                   : sentence);
  }
  fmt::print(stderr, "{}", errors.text());  // warnings
  try {
    return command_of(json::parse(json::parse(output.text()).get<std::string>()).at(0));
  } catch (const json::exception&) {
    throw Failure(fmt::format(
        "{} is not a valid Python command: its ARGUMENTS must come from lichtenberg.commands.argument", module));
  }
}

void draw(const std::string& function, std::vector<std::string> words) {
  words.insert(words.begin(), {"--draw", function});
  if (!run_package(std::move(words))) throw Failure("the picture was not drawn (see the plot script's message above)");
}

void draw_picture(const std::string& file, double& seconds) {
  const Stopwatch stopwatch(seconds);
  try {
    draw("frames.draw_run", {as_word(file)});
  } catch (const Failure& failure) {
    fmt::print(stderr, "lichtenberg: {}\n", printable(failure.what()));
  }
}

}  // namespace lichtenberg
