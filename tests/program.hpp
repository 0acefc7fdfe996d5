#pragma once

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/folder.hpp"

/// The built program as called by a user. For tests that CMakeLists.txt gives LICHTENBERG_BINARY to.
namespace lichtenberg {

struct Ended {
  int status;
  std::string out, err;
};

/// Runs a shell command in the folder with LICHTENBERG replaced by the program. The files out and err there contain its
/// output; output that the command redirects is not read back.
inline Ended run_shell(const Folder& folder, std::string command) {
  for (std::size_t at; (at = command.find("LICHTENBERG")) != std::string::npos;)
    command.replace(at, 11, "'" LICHTENBERG_BINARY "'");
  const int status =
      std::system(fmt::format("cd '{}' && {{ {}; }} >out 2>err </dev/null", folder.path.string(), command).c_str());
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), text_of(folder / "out"), text_of(folder / "err")};
}

/// Runs the program in the folder; `arguments` as in a shell.
inline Ended run_program(const Folder& folder, const std::string& arguments) {
  return run_shell(folder, "LICHTENBERG " + arguments);
}

}  // namespace lichtenberg
