// Runs one of the validation programs: validation NAME [arguments of the program].
#include <fmt/format.h>

#include <cstdio>

#include "validation/program.hpp"

int main(int argc, char** argv) {
  const auto& programs = lichtenberg::validation::programs();
  const auto found = programs.find(argc > 1 ? argv[1] : "");
  if (found != programs.end()) return found->second(argc - 1, argv + 1);
  fmt::print(stderr, "validation: the first argument must be one of these programs:\n");
  for (const auto& entry : programs) fmt::print(stderr, "  {}\n", entry.first);
  return 2;
}
