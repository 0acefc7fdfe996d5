// Fuzzing in process: fuzz scenes|gases|results [--cases N] [--seed S] [--first K] [--keep FOLDER].
//
// fuzz draw --keep FOLDER only writes damaged results, each to a folder of its number, for readers.py.
// Exit status 1 if a case breaks a rule: no signal, no sanitizer report, no hang; only the program's own errors, each
// with a message; no silent NaN. A case is the same for its number and seed.
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

/// Writes inputs without trying them. Returns 0.
std::uint64_t draw(const Target& target, const Request& request) {
  if (request.keep.empty()) throw std::invalid_argument("draw needs --keep FOLDER, where it writes the inputs");
  const fs::path folder = fs::current_path();
  for (std::uint64_t number = request.first; number < request.first + request.cases; ++number) {
    Dice dice(request.seed, number);
    const fs::path own = request.keep / fs::path(std::to_string(number));
    fs::create_directories(own);
    fs::current_path(own);
    write_files(target.draw(dice));
  }
  fs::current_path(folder);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, Target (*)()> targets{
      {"scenes", scenes}, {"gases", gases}, {"results", results}, {"draw", results}};
  try {
    const auto target = targets.at(argc > 1 ? argv[1] : "");
    const Request request = request_of(argc, argv);
    const fs::path memory = "/dev/shm", folder = (fs::exists(memory) ? memory : fs::temp_directory_path()) /
                                                 fmt::format("lichtenberg-fuzz-{}", getpid());
    fs::create_directory(folder);
    fs::current_path(folder);
    const bool draws_only = std::string(argv[1]) == "draw";
    const std::uint64_t broken = draws_only ? draw(target(), request) : supervise(target(), request);
    fs::remove_all(folder);
    return broken > 0 ? 1 : 0;
  } catch (const std::exception& error) {
    fmt::print(stderr,
               "fuzz: {}; usage: fuzz scenes|gases|results|draw [--cases N] [--seed S] [--first K] [--keep FOLDER]\n",
               error.what());
    return 2;
  }
}
