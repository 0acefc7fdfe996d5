// This file is compiled with the flags of the whole program, which define these macros.
#include "src/instruction_sets.hpp"

#define LICHTENBERG_TEXT(text) #text
#define LICHTENBERG_HAS(macro) (LICHTENBERG_TEXT(macro)[0] == '1')  // an undefined macro expands to its own name
#define LICHTENBERG_COMPILED(name, macro, words) LICHTENBERG_HAS(macro),

namespace lichtenberg {

constinit const bool compiled_for[] = {LICHTENBERG_INSTRUCTION_SETS(LICHTENBERG_COMPILED)};

}  // namespace lichtenberg
