// Checks that this processor has all instructions for which the program was compiled, and ends the program with an
// error message if not. Only this file is compiled for any processor (CMakeLists.txt), and its code runs before all
// other code.
#if defined(__x86_64__) && defined(__GNUC__)

#include <unistd.h>

#include <cstring>

#include "src/instruction_sets.hpp"

namespace lichtenberg {
namespace {

void say(const char* text) {
  if (write(STDERR_FILENO, text, std::strlen(text)) < 0) _exit(1);
}

void require(bool compiled, int present, const char* name) {
  if (!compiled || present != 0) return;
  say("lichtenberg: this program was compiled for processors with ");
  say(name);
  say(", which this one lacks: build it on this machine, or with -D LICHTENBERG_NATIVE=OFF for any\n");
  _exit(1);
}

constexpr int before_all_others = 101;  // lowest priority number that programs may use

__attribute__((constructor(before_all_others))) void check_processor() {
  __builtin_cpu_init();
  const bool* compiled = compiled_for;
#define LICHTENBERG_REQUIRE(name, macro, words) require(*compiled++, __builtin_cpu_supports(name), words);
  LICHTENBERG_INSTRUCTION_SETS(LICHTENBERG_REQUIRE)
}

}  // namespace
}  // namespace lichtenberg

#endif
