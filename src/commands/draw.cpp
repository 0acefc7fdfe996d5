#include "src/commands/draw.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

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

/// Python, the script and its arguments as exec wants them.
class CommandLine {
 public:
  CommandLine(const std::string& script, const std::vector<std::string>& arguments)
      : words_{python, find_script(script).string()} {
    words_.insert(words_.end(), arguments.begin(), arguments.end());
    for (std::string& word : words_) pointers_.push_back(word.data());
    pointers_.push_back(nullptr);
  }
  CommandLine(const CommandLine&) = delete;
  char** argv() { return pointers_.data(); }

 private:
  std::vector<std::string> words_;
  std::vector<char*> pointers_;
};

[[noreturn]] void refuse_start(int error) {
  throw Failure(fmt::format("cannot draw: {} does not start ({})", python, std::strerror(error)));
}

}  // namespace

void draw(const std::string& name, const std::vector<std::string>& arguments) {
  CommandLine command(name, arguments);
  pid_t script = 0;
  const int error = posix_spawn(&script, python, nullptr, nullptr, command.argv(), environ);
  if (error != 0) refuse_start(error);
  int status = 0;
  while (waitpid(script, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("cannot draw: lost the plot script ({})", std::strerror(errno)));
  if (status != 0) throw Failure("the picture was not drawn (the plot script says above why)");
}

void draw_picture(const std::string& file, double& seconds) {
  const Stopwatch stopwatch(seconds);
  try {
    draw("plot.py", {file, "--of-run"});
  } catch (const Failure& failure) {
    fmt::print(stderr, "lichtenberg: {}\n", failure.what());
  }
}

void become_script(const std::string& name, const std::vector<std::string>& arguments) {
  CommandLine command(name, arguments);
  parallel::finish_petsc();  // which no exit handler does any more
  execve(python, command.argv(), environ);
  refuse_start(errno);
}

}  // namespace lichtenberg
