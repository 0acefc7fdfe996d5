#pragma once

namespace lichtenberg {

/// Instruction sets that not every processor has.
struct InstructionSets {
  bool sse4_2, popcnt, avx, avx2, fma, bmi, bmi2;
  bool avx512f, avx512cd, avx512dq, avx512bw, avx512vl, avx512er, avx512pf;
  bool avx512vbmi, avx512vbmi2, avx512ifma, avx512vnni, avx512bitalg, avx512vpopcntdq, avx512bf16;
};

/// Instruction sets for which the program was compiled. The constant can be read before any constructor has run.
extern const InstructionSets compiled_for;

}  // namespace lichtenberg
