#pragma once

/// Macro in front of a loop: unrolls the loop `times` times (1: no unrolling), by the pragma of the current compiler.
#define LICHTENBERG_PRAGMA(text) _Pragma(#text)
#ifdef __CUDACC__
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(unroll times)
#else
#define LICHTENBERG_UNROLL(times) LICHTENBERG_PRAGMA(GCC unroll times)
#endif
