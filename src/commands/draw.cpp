#include "src/commands/draw.hpp"
#include "src/commands/streams.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "solvers/stopwatch.hpp"

namespace lichtenberg {
namespace {

constexpr const char* python = "/usr/bin/python3";  // Debian's, which sees Debian's h5py and matplotlib

/// Beside an installed program first, so that an installation does not depend on the source it came from.
std::filesystem::path find_script(const std::string& name) {
  // Not `canonical`: a program that was rebuilt while it ran is no longer there, and its link says so.
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  for (const char* place : {SCRIPTS_FROM_BINARY, SCRIPTS_IN_SOURCE}) {
    const std::filesystem::path script = program.parent_path() / place / name;
    if (std::filesystem::exists(script)) return script.lexically_normal();
  }
  throw Failure(fmt::format("cannot draw: {} is neither in {} beside {} nor in {}", name, SCRIPTS_FROM_BINARY,
                            program.string(), SCRIPTS_IN_SOURCE));
}

/// Words as exec wants them.
class Words {
 public:
  explicit Words(std::vector<std::string> words) : words_(std::move(words)) {
    for (std::string& word : words_) pointers_.push_back(word.data());
    pointers_.push_back(nullptr);
  }
  Words(const Words&) = delete;
  char** data() { return pointers_.data(); }

 private:
  std::vector<std::string> words_;
  std::vector<char*> pointers_;
};

/// Python, the script and its arguments.
std::vector<std::string> command_line(const std::string& script, const std::vector<std::string>& arguments) {
  std::vector<std::string> words{python, find_script(script).string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

/// Ours, and that this process waits for the script, which is to end with it (interrupted.py).
std::vector<std::string> environment_of_waiting() {
  std::vector<std::string> words{fmt::format("LICHTENBERG_WAITS={}", getpid())};
  for (char** word = environ; *word; ++word) words.emplace_back(*word);
  return words;
}

[[noreturn]] void refuse_start(int error) {
  throw Failure(fmt::format("cannot draw: {} does not start ({})", python, std::strerror(error)));
}

}  // namespace

void draw(const std::string& name, const std::vector<std::string>& arguments) {
  Words command(command_line(name, arguments)), environment(environment_of_waiting());
  pid_t script = 0;
  const int error = posix_spawn(&script, python, nullptr, nullptr, command.data(), environment.data());
  if (error != 0) refuse_start(error);
  int status = 0;
  while (waitpid(script, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("cannot draw: lost the plot script ({})", std::strerror(errno)));
  if (status != 0) throw Failure("the picture was not drawn (the plot script says above why)");
}

void draw_picture(const std::string& file, double& seconds) {
  const Stopwatch stopwatch(seconds);
  try {
    draw("plot.py", {as_word(file), "--of-run"});
  } catch (const Failure& failure) {
    fmt::print(stderr, "lichtenberg: {}\n", printable(failure.what()));
  }
}

void become_script(const std::string& name, const std::vector<std::string>& arguments) {
  Words command(command_line(name, arguments));
  parallel::finish_petsc();  // which no exit handler does any more
  execve(python, command.data(), environ);
  refuse_start(errno);
}

}  // namespace lichtenberg
