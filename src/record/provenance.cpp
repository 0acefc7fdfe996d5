#include "src/record/provenance.hpp"

#include <fmt/chrono.h>
#include <pwd.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <thread>

namespace lichtenberg {
namespace {

std::string user_name() {
  const passwd* entry = getpwuid(geteuid());
  return entry != nullptr ? entry->pw_name : "unknown";
}

/// The words of the command line with spaces between them.
std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string words{std::istreambuf_iterator<char>(file), {}};
  if (!words.empty()) words.pop_back();  // the last word's terminating zero
  std::replace(words.begin(), words.end(), '\0', ' ');
  return words;
}

std::string machine() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return fmt::format("{}, {} {} {}", name.nodename, name.sysname, name.release, name.machine);
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
  return "unknown";
}

}  // namespace

Provenance provenance() {
  Provenance here;
  here.user = user_name();
  here.command_line = command_line();
  if (const char* options = std::getenv("PETSC_OPTIONS")) here.petsc_options = options;
  here.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  here.machine = machine();
  here.processor = processor();
  here.cores = static_cast<int>(std::thread::hardware_concurrency());
  return here;
}

}  // namespace lichtenberg
