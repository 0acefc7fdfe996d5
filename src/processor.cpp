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
  const InstructionSets& sets = compiled_for;
  require(sets.sse4_2, __builtin_cpu_supports("sse4.2"), "SSE 4.2");
  require(sets.popcnt, __builtin_cpu_supports("popcnt"), "POPCNT");
  require(sets.avx, __builtin_cpu_supports("avx"), "AVX");
  require(sets.avx2, __builtin_cpu_supports("avx2"), "AVX2");
  require(sets.fma, __builtin_cpu_supports("fma"), "FMA");
  require(sets.bmi, __builtin_cpu_supports("bmi"), "BMI");
  require(sets.bmi2, __builtin_cpu_supports("bmi2"), "BMI2");
  require(sets.avx512f, __builtin_cpu_supports("avx512f"), "AVX-512");
  require(sets.avx512cd, __builtin_cpu_supports("avx512cd"), "AVX-512 CD");
  require(sets.avx512dq, __builtin_cpu_supports("avx512dq"), "AVX-512 DQ");
  require(sets.avx512bw, __builtin_cpu_supports("avx512bw"), "AVX-512 BW");
  require(sets.avx512vl, __builtin_cpu_supports("avx512vl"), "AVX-512 VL");
  require(sets.avx512er, __builtin_cpu_supports("avx512er"), "AVX-512 ER");
  require(sets.avx512pf, __builtin_cpu_supports("avx512pf"), "AVX-512 PF");
  require(sets.avx512vbmi, __builtin_cpu_supports("avx512vbmi"), "AVX-512 VBMI");
  require(sets.avx512vbmi2, __builtin_cpu_supports("avx512vbmi2"), "AVX-512 VBMI2");
  require(sets.avx512ifma, __builtin_cpu_supports("avx512ifma"), "AVX-512 IFMA");
  require(sets.avx512vnni, __builtin_cpu_supports("avx512vnni"), "AVX-512 VNNI");
  require(sets.avx512bitalg, __builtin_cpu_supports("avx512bitalg"), "AVX-512 BITALG");
  require(sets.avx512vpopcntdq, __builtin_cpu_supports("avx512vpopcntdq"), "AVX-512 VPOPCNTDQ");
  require(sets.avx512bf16, __builtin_cpu_supports("avx512bf16"), "AVX-512 BF16");
}

}  // namespace
}  // namespace lichtenberg

#endif
