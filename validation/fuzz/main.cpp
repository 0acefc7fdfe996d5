// Fuzzing in process: fuzz scenes|results [--cases N] [--seed S] [--first K] [--keep FOLDER].
//
// Exit status 1 if a case breaks a rule: no signal, no sanitizer report, no hang; only the program's own errors, each
// with a message of one line; no silent NaN. A case is the same for its number and seed.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "validation/fuzz/fuzz.hpp"

namespace {

using namespace lichtenberg::fuzz;
namespace fs = std::filesystem;

Request request_of(int argc, char** argv) {
  Request request;
  const std::map<std::string, std::uint64_t Request::*> numbers{
      {"--cases", &Request::cases}, {"--seed", &Request::seed}, {"--first", &Request::first}};
  for (int k = 2; k < argc; k += 2) {
    const std::string name = argv[k], value = k + 1 < argc ? argv[k + 1] : "";
    if (name == "--keep")
      request.keep = fs::absolute(value);
    else
      request.*numbers.at(name) = std::stoull(value);
  }
  return request;
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, Target (*)()> targets{{"scenes", scenes}, {"results", results}};
  try {
    const auto target = targets.at(argc > 1 ? argv[1] : "");
    const Request request = request_of(argc, argv);
    const fs::path memory = "/dev/shm", folder = (fs::exists(memory) ? memory : fs::temp_directory_path()) /
                                                 fmt::format("lichtenberg-fuzz-{}", getpid());
    fs::create_directory(folder);
    fs::current_path(folder);
    const std::uint64_t broken = supervise(target(), request);
    fs::remove_all(folder);
    return broken > 0 ? 1 : 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "fuzz: {}; usage: fuzz scenes|results [--cases N] [--seed S] [--first K] [--keep FOLDER]\n",
               error.what());
    return 2;
  }
}
