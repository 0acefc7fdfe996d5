#pragma once

/// List of the instruction sets of processors that a compiler may use. The arguments of X are the name for
/// __builtin_cpu_supports, the compiler's macro that is 1 for programs that use the set, and the name in messages.
#define LICHTENBERG_INSTRUCTION_SETS(X)                          \
  X("sse4.2", __SSE4_2__, "SSE 4.2")                             \
  X("popcnt", __POPCNT__, "POPCNT")                              \
  X("avx", __AVX__, "AVX")                                       \
  X("avx2", __AVX2__, "AVX2")                                    \
  X("fma", __FMA__, "FMA")                                       \
  X("bmi", __BMI__, "BMI")                                       \
  X("bmi2", __BMI2__, "BMI2")                                    \
  X("avx512f", __AVX512F__, "AVX-512")                           \
  X("avx512cd", __AVX512CD__, "AVX-512 CD")                      \
  X("avx512dq", __AVX512DQ__, "AVX-512 DQ")                      \
  X("avx512bw", __AVX512BW__, "AVX-512 BW")                      \
  X("avx512vl", __AVX512VL__, "AVX-512 VL")                      \
  X("avx512er", __AVX512ER__, "AVX-512 ER")                      \
  X("avx512pf", __AVX512PF__, "AVX-512 PF")                      \
  X("avx512vbmi", __AVX512VBMI__, "AVX-512 VBMI")                \
  X("avx512vbmi2", __AVX512VBMI2__, "AVX-512 VBMI2")             \
  X("avx512ifma", __AVX512IFMA__, "AVX-512 IFMA")                \
  X("avx512vnni", __AVX512VNNI__, "AVX-512 VNNI")                \
  X("avx512bitalg", __AVX512BITALG__, "AVX-512 BITALG")          \
  X("avx512vpopcntdq", __AVX512VPOPCNTDQ__, "AVX-512 VPOPCNTDQ") \
  X("avx512bf16", __AVX512BF16__, "AVX-512 BF16")

namespace lichtenberg {

/// For each instruction set of the list: true if the program was compiled for it. Can be read before any constructor
/// has run.
extern const bool compiled_for[];

}  // namespace lichtenberg
