#pragma once

// Description of the machine and program for benchmark output.

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <thread>

#include "src/version.hpp"

namespace lichtenberg::benchmarks {

/// Returns the name of the processor from /proc/cpuinfo.
inline std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

/// Returns a line for benchmark tables: the program's commit, the processor and its number of cores.
inline std::string machine() {
  return fmt::format("lichtenberg {}, {}, {} cores", lichtenberg_version().commit, processor(),
                     std::thread::hardware_concurrency());
}

}  // namespace lichtenberg::benchmarks
