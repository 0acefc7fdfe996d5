#include "src/commands/draw.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

constexpr const char* python = "/usr/bin/python3";  // Debian's, which sees Debian's h5py and matplotlib

/// Beside an installed program first, so that an installation does not depend on the source it came from.
std::filesystem::path plot_script() {
  const std::filesystem::path program = std::filesystem::canonical("/proc/self/exe");
  for (const char* place : {PLOT_SCRIPT_FROM_BINARY, PLOT_SCRIPT_IN_SOURCE}) {
    const std::filesystem::path script = program.parent_path() / place;
    if (std::filesystem::exists(script)) return script.lexically_normal();
  }
  throw Failure(fmt::format("cannot draw: the plot script is neither at {} beside {} nor at {}",
                            PLOT_SCRIPT_FROM_BINARY, program.string(), PLOT_SCRIPT_IN_SOURCE));
}

/// Exit status of a program, its standard streams ours.
int run_and_wait(std::vector<std::string> words) {
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawn(&child, argv[0], nullptr, nullptr, argv.data(), environ);
  if (error != 0) throw Failure(fmt::format("cannot draw: {} does not start ({})", words[0], std::strerror(error)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("cannot draw: lost {} ({})", words[0], std::strerror(errno)));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

void draw(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{python, plot_script().string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const int status = run_and_wait(words);
  if (status == 2) throw InputError("the plot script refused its input (its message stands above)");
  if (status != 0) throw Failure(fmt::format("the plot script failed with exit status {}", status));
}

}  // namespace lichtenberg
