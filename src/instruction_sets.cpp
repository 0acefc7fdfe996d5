// This file is compiled with the flags of the whole program, which define these macros.
#include "src/instruction_sets.hpp"

#define LICHTENBERG_TEXT(text) #text
#define LICHTENBERG_HAS(macro) (LICHTENBERG_TEXT(macro)[0] == '1')  // an undefined macro expands to its own name

namespace lichtenberg {

constinit const InstructionSets compiled_for = {.sse4_2 = LICHTENBERG_HAS(__SSE4_2__),
                                                .popcnt = LICHTENBERG_HAS(__POPCNT__),
                                                .avx = LICHTENBERG_HAS(__AVX__),
                                                .avx2 = LICHTENBERG_HAS(__AVX2__),
                                                .fma = LICHTENBERG_HAS(__FMA__),
                                                .bmi = LICHTENBERG_HAS(__BMI__),
                                                .bmi2 = LICHTENBERG_HAS(__BMI2__),
                                                .avx512f = LICHTENBERG_HAS(__AVX512F__),
                                                .avx512cd = LICHTENBERG_HAS(__AVX512CD__),
                                                .avx512dq = LICHTENBERG_HAS(__AVX512DQ__),
                                                .avx512bw = LICHTENBERG_HAS(__AVX512BW__),
                                                .avx512vl = LICHTENBERG_HAS(__AVX512VL__),
                                                .avx512er = LICHTENBERG_HAS(__AVX512ER__),
                                                .avx512pf = LICHTENBERG_HAS(__AVX512PF__),
                                                .avx512vbmi = LICHTENBERG_HAS(__AVX512VBMI__),
                                                .avx512vbmi2 = LICHTENBERG_HAS(__AVX512VBMI2__),
                                                .avx512ifma = LICHTENBERG_HAS(__AVX512IFMA__),
                                                .avx512vnni = LICHTENBERG_HAS(__AVX512VNNI__),
                                                .avx512bitalg = LICHTENBERG_HAS(__AVX512BITALG__),
                                                .avx512vpopcntdq = LICHTENBERG_HAS(__AVX512VPOPCNTDQ__),
                                                .avx512bf16 = LICHTENBERG_HAS(__AVX512BF16__)};

}  // namespace lichtenberg
